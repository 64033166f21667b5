#pragma once

#include <modsearch/baselines/certify/node_prover_internal.hpp>
#include <string>

namespace modsearch::certify {

/// A number as certificates have it: a JSON text with a hexadecimal float.
[[nodiscard]] std::string hex(double number);

/// Nodes of a certificate's tree in preorder, as JSON, separated by commas.
class TreeText {
 public:
  /// That half a circle is enough of an angle; before all else.
  void halve(int variable);
  /// Parts that are cut off one box.
  void cut_off(const std::vector<CutOff>& cuts);
  void split(int variable, double at);
  void close(const ClosedLeaf& leaf);
  void append(const TreeText& other);

  [[nodiscard]] const std::string& nodes() const { return nodes_; }
  [[nodiscard]] std::int64_t leaves() const { return leaves_; }

 private:
  void begin();
  void leaf(const ClosedLeaf& closed);

  std::string nodes_;
  std::int64_t leaves_ = 0;
};

}  // namespace modsearch::certify
