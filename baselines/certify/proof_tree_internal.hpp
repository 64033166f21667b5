#pragma once

#include <functional>
#include <modsearch/baselines/certify/node_prover_internal.hpp>
#include <string>

namespace modsearch::certify {

/// A number as certificates have it: a JSON text with a hexadecimal float.
[[nodiscard]] std::string hex(double number);

/// How the proof for one type sequence ended.
struct ProofOutcome {
  bool whole = false;  ///< all boxes are closed
  std::string open;    ///< otherwise: why not
  std::string nodes;   ///< the tree in preorder, a JSON list
  std::int64_t leaves = 0;
};

/// Closes all boxes of a sequence against one fixed cut, depth first, and writes the tree down as it goes: smaller and
/// cleaner than that of the search, whose cut moves. `cut`: see NodeProver::prove. `stop` is asked before every box.
[[nodiscard]] ProofOutcome prove_sequence(const SequenceModel& model, const Scenery& scenery, double cut,
                                          const std::function<bool()>& stop);

/// The checker's own test by the length of the arm says that no achieved design of the sequence scores above `upper`
/// (-inf: that none is achieved). `head`: score of no mass; `weight`: points per kilogram.
[[nodiscard]] bool out_of_reach(const SequenceModel& model, const Scenery& scenery, double head, double weight,
                                double upper);

}  // namespace modsearch::certify
