#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <modsearch/baselines/certify/tree_text_internal.hpp>
#include <string_view>

namespace modsearch::certify {

std::string hex(double number) {
  char digits[48];
  const auto [end, error] =
      std::to_chars(std::begin(digits), std::end(digits), std::abs(number), std::chars_format::hex);
  return fmt::format("\"{}0x{}\"", std::signbit(number) ? "-" : "", std::string_view{digits, end});
}

void TreeText::begin() {
  if (!nodes_.empty()) nodes_ += ',';
}

void TreeText::halve(int variable) {
  begin();
  fmt::format_to(std::back_inserter(nodes_), "[\"h\",{}]", variable);
}

void TreeText::cut_off(const std::vector<CutOff>& cuts) {
  if (cuts.empty()) return;
  begin();
  nodes_ += "[\"c\"";
  for (const CutOff& cut : cuts) {
    nodes_ += ",[";
    leaf(cut.leaf);
    for (const CutOff::Part& part : cut.parts) {
      fmt::format_to(std::back_inserter(nodes_), ",[{},{},\"{}\"]", part.variable, hex(part.at),
                     part.above ? "above" : "below");
    }
    nodes_ += ']';
  }
  nodes_ += ']';
}

void TreeText::split(int variable, double at) {
  begin();
  fmt::format_to(std::back_inserter(nodes_), "[\"s\",{},{}]", variable, hex(at));
}

void TreeText::close(const ClosedLeaf& closed) {
  begin();
  leaf(closed);
}

void TreeText::append(const TreeText& other) {
  if (other.nodes_.empty()) return;
  begin();
  nodes_ += other.nodes_;
  leaves_ += other.leaves_;
}

void TreeText::leaf(const ClosedLeaf& closed) {
  ++leaves_;
  const Multipliers& m = closed.multipliers;
  nodes_ += closed.kind == Objective::kMass ? "[\"m" : "[\"n";
  nodes_ += m.cap ? "c\"" : "\"";
  const auto out = std::back_inserter(nodes_);
  for (const Eigen::Vector3d& y : m.y) fmt::format_to(out, ",{},{},{}", hex(y.x()), hex(y.y()), hex(y.z()));
  for (const Row& row : m.rows) {
    fmt::format_to(out, ",[{},{},{},{},{},", row.goal, row.run, hex(row.tau), hex(row.multiplier), row.shape);
    if (row.ball) {
      fmt::format_to(out, "\"ball\",{},{},{},{}]", hex(row.centre.x()), hex(row.centre.y()), hex(row.centre.z()),
                     hex(row.radius));
    } else {
      fmt::format_to(out, "\"face\",{}]", row.face);
    }
  }
  nodes_ += ']';
}

}  // namespace modsearch::certify
