#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>
#include <modsearch/rl/training_csv.hpp>
#include <variant>

namespace modsearch {
namespace {

/// A column and where its numbers belong.
struct Column {
  std::string_view name;
  std::variant<std::int64_t EvaluationPoint::*, double EvaluationPoint::*, double EvaluationSummary::*> member;
};

constexpr Column kColumns[] = {
    {"episode", &EvaluationPoint::episode},
    {"steps", &EvaluationPoint::steps},
    {"updates", &EvaluationPoint::updates},
    {"epsilon", &EvaluationPoint::epsilon},
    {"training_return", &EvaluationPoint::training_return},
    {"evaluation_return", &EvaluationSummary::mean_return},
    {"evaluation_deviation", &EvaluationSummary::deviation},
    {"success_share", &EvaluationSummary::success_share},
    {"one_step_share", &EvaluationSummary::one_step_share},
    {"evaluation_steps", &EvaluationSummary::mean_steps},
    {"value_loss", &EvaluationPoint::value_loss},
    {"training_s", &EvaluationPoint::seconds},
};

template <typename Point, typename T>
auto& field(Point& point, T EvaluationPoint::*member) {
  return point.*member;
}
template <typename Point>
auto& field(Point& point, double EvaluationSummary::*member) {
  return point.evaluation.*member;
}

std::string line_of(const EvaluationPoint& point) {
  std::string line;
  for (const Column& column : kColumns) {
    if (!line.empty()) line += ',';
    // The shortest text that reads back as the same number.
    line += std::visit([&](auto member) { return fmt::format("{}", field(point, member)); }, column.member);
  }
  return line + '\n';
}

/// Takes what precedes the next `end` off `text`, and `end` with it.
std::string_view take(std::string_view& text, char end) {
  const std::size_t found = std::min(text.find(end), text.size());
  const std::string_view taken = text.substr(0, found);
  text.remove_prefix(std::min(found + 1, text.size()));
  return taken;
}

template <typename T>
bool parse(std::string_view text, T& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

std::string training_csv_columns() {
  std::string line;
  for (const Column& column : kColumns) {
    if (!line.empty()) line += ',';
    line += column.name;
  }
  return line;
}

std::vector<EvaluationPoint> load_training_csv(const std::filesystem::path& file) {
  const std::string whole = detail::read_text(file, file.string());
  // A row without its end was being written when somebody pulled the plug.
  std::string_view text = std::string_view{whole}.substr(0, whole.rfind('\n') + 1);
  const auto refuse = [&](std::size_t number, const std::string& what) {
    throw FileError(fmt::format("{}: line {}: {}", file.string(), number, what));
  };
  if (take(text, '\n') != training_csv_columns()) {
    refuse(1, fmt::format("is not the header of a training's log (limit: \"{}\")", training_csv_columns()));
  }
  std::vector<EvaluationPoint> rows;
  while (!text.empty()) {
    const std::size_t number = rows.size() + 2;
    std::string_view line = take(text, '\n');
    const auto n_fields = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
    if (n_fields != std::size(kColumns)) {
      refuse(number, fmt::format("has {} fields (limit {})", n_fields, std::size(kColumns)));
    }
    EvaluationPoint& point = rows.emplace_back();
    for (const Column& column : kColumns) {
      const std::string_view entry = take(line, ',');
      if (!std::visit([&](auto member) { return parse(entry, field(point, member)); }, column.member)) {
        refuse(number, fmt::format("{} is '{}', not a number", column.name, entry.substr(0, 40)));
      }
    }
  }
  return rows;
}

TrainingCsv::TrainingCsv(const std::filesystem::path& file, const std::vector<EvaluationPoint>& rows) : path_{file} {
  std::string text = training_csv_columns() + '\n';
  for (const EvaluationPoint& row : rows) text += line_of(row);
  write_file(file, text);
  file_.reset(std::fopen(file.c_str(), "ab"));
  if (file_ == nullptr) fail();
}

void TrainingCsv::append(const EvaluationPoint& point) {
  const std::string line = line_of(point);
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() || std::fflush(file_.get()) != 0) fail();
}

void TrainingCsv::fail() const {
  throw FileError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
}

}  // namespace modsearch
