#pragma once

#include <functional>
#include <modsearch/baselines/certify/tree_text_internal.hpp>
#include <string>

namespace modsearch::certify {

/// How the proof for one type sequence ended.
struct ProofOutcome {
  bool whole = false;   ///< all boxes are closed
  std::string open{};   ///< otherwise: why not
  bool in_time = true;  ///< and whether that was something else than the time
  std::string nodes{};  ///< the tree in preorder, a JSON list
  std::int64_t leaves = 0;
};

/// Closes `box` against one fixed cut, depth first, and writes down how. False: it does not close, and `open` and
/// `in_time` say why. `cut`: see NodeProver::prove. `stop` is asked before every box.
[[nodiscard]] bool close_box(NodeProver& prover, Box box, Multipliers multipliers, double cut,
                             const std::function<bool()>& stop, TreeText& text, ProofOutcome& outcome);

/// Closes all boxes of a sequence so.
[[nodiscard]] ProofOutcome prove_sequence(const SequenceModel& model, const Scenery& scenery, double cut,
                                          const std::function<bool()>& stop);

/// The checker's own test by the length of the arm says that no achieved design of the sequence scores above `upper`
/// (-inf: that none is achieved). `head`: score of no mass; `weight`: points per kilogram.
[[nodiscard]] bool out_of_reach(const SequenceModel& model, const Scenery& scenery, double head, double weight,
                                double upper);

}  // namespace modsearch::certify
