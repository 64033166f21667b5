#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/baselines/certify/bound_search_internal.hpp>
#include <modsearch/baselines/certify/proof_tree_internal.hpp>
#include <modsearch/kinematics/separation.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using certify::hex;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A JSON text. IDs of modules are free text.
std::string json_text(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  result += '"';
  return result;
}

std::string hex3(const Eigen::Vector3d& v) { return fmt::format("[{},{},{}]", hex(v.x()), hex(v.y()), hex(v.z())); }

// The numbers of the problem, once more: a certificate is about them.
std::string statement(const RobotProblem& problem, const std::string& scoring) {
  std::string text = "{\"library\":{";
  const ModuleLibrary& library = problem.library();
  for (int k = 0; k < library.n_types(); ++k) {
    text += fmt::format("{}{}:{{", k > 0 ? "," : "", json_text(library.type(k).id));
    bool first = true;
    for (const ParameterRange& range : library.type(k).parameters) {
      text += fmt::format("{}{}:[{},{}]", first ? "" : ",", json_text(range.name), hex(range.lower), hex(range.upper));
      first = false;
    }
    text += "}";
  }
  text += "},\"goals\":[";
  bool first = true;
  for (const Goal& goal : problem.task().goals()) {
    text += fmt::format("{}{{\"position\":{},\"radius\":{}}}", first ? "" : ",", hex3(goal.position()),
                        hex(goal.region.tolerances()[0].upper));
    first = false;
  }
  std::size_t shapes = 0;
  for (const Obstacle& obstacle : problem.scene().obstacles()) shapes += obstacle.shapes.size();
  return text + fmt::format("],\"scoring\":{},\"maxModules\":{},\"collision\":{},\"obstacles\":{}}}", scoring,
                            problem.max_modules(), json_text(name(problem.spec().level)), shapes);
}

// The design, its postures, and planes between its bodies and the obstacles next to them.
std::string incumbent(const RobotProblem& problem, const certify::Witness& witness) {
  constexpr double kNear = 0.05;  // what is farther away is easily seen to be so
  std::string text = "{\"design\":[";
  for (std::size_t i = 0; i < witness.design.modules.size(); ++i) {
    const Placement& placement = witness.design.modules[i];
    const ModuleType& type = problem.library().type(placement.type);
    text += fmt::format("{}{{\"type\":{},\"parameters\":{{", i > 0 ? "," : "", json_text(type.id));
    for (std::size_t p = 0; p < type.parameters.size(); ++p) {
      text += fmt::format("{}{}:{}", p > 0 ? "," : "", json_text(type.parameters[p].name),
                          hex(placement.parameters[static_cast<Eigen::Index>(p)]));
    }
    text += "}}";
  }
  text += "],\"postures\":[";
  std::string separations;
  const std::shared_ptr<const Chain> chain = problem.chain(witness.design.types());
  const Arm arm = chain->at(witness.design.parameters());
  for (Eigen::Index g = 0; g < witness.postures.rows(); ++g) {
    text += g > 0 ? ",[" : "[";
    for (Eigen::Index j = 0; j < witness.postures.cols(); ++j) {
      text += fmt::format("{}{}", j > 0 ? "," : "", hex(witness.postures(g, j)));
    }
    text += "]";
    if (problem.spec().level == Level::kNone) continue;
    const Posture posture = arm.forward(witness.postures.row(g));
    for (std::size_t body = 0; body < arm.geometries().size(); ++body) {
      const ArmGeometry& geometry = arm.geometries()[body];
      const Eigen::Isometry3d X_WG = posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
      std::size_t shape = 0;
      for (const Obstacle& obstacle : problem.scene().obstacles()) {
        for (const PlacedShape& placed : obstacle.shapes) {
          const Separation apart = separation(geometry.shape, X_WG, placed.shape, placed.X_FG);
          if (apart.distance < kNear) {
            separations += fmt::format("{}{{\"goal\":{},\"body\":{},\"shape\":{},\"normal\":{}}}",
                                       separations.empty() ? "" : ",", g, body, shape, hex3(apart.normal_W));
          }
          ++shape;
        }
      }
    }
  }
  return fmt::format("{}],\"separations\":[{}]}}", text, separations);
}

// Proves that no achieved design scores above a bound, sequence by sequence, in the order of the checker.
class Proof {
 public:
  /// What `search` has closed is taken from it.
  Proof(const RobotProblem& problem, certify::BoundSearch& search, Meter& meter)
      : problem_{problem},
        search_{search},
        scenery_{certify::scenery_of(problem)},
        weight_{problem.spec().scoring->mass_weight()},
        meter_{meter},
        stop_{[this] { return meter_.stopped().has_value(); }} {}

  // False: something is left open, see open().
  [[nodiscard]] bool run(double upper) {
    upper_ = upper;
    text_.clear();
    leaves_ = 0;
    n_sequences_ = 0;
    for (int n = 0; n < problem_.max_modules(); ++n) {
      if (best_of_length(n) <= upper_) continue;
      std::vector<int> types;
      if (!extend(types, n)) return false;
    }
    return true;
  }

  [[nodiscard]] const std::string& open() const { return open_; }
  /// False: only the time was too short.
  [[nodiscard]] bool in_time() const { return in_time_; }
  [[nodiscard]] const std::string& sequences() const { return text_; }
  [[nodiscard]] std::int64_t leaves() const { return leaves_; }
  [[nodiscard]] std::int64_t n_sequences() const { return n_sequences_; }

 private:
  // As the checker has it: the lightest and the cheapest module, n times.
  [[nodiscard]] double best_of_length(int n) const {
    const ModuleLibrary& library = problem_.library();
    if (n > 0 && library.n_types() == 0) return -kInfinity;
    double mass = module_span(library.base()).mass;
    double cost = library.base().cost;
    double least = kInfinity;
    double cheapest = kInfinity;
    for (int k = 0; k < library.n_types(); ++k) {
      least = std::min(least, module_span(library.type(k)).mass);
      cheapest = std::min(cheapest, library.type(k).cost);
    }
    if (n > 0) {
      mass += n * least;
      cost += n * cheapest;
    }
    return problem_.spec().scoring->bound(n + 1, mass, cost);
  }

  [[nodiscard]] bool extend(std::vector<int>& types, int n) {
    if (static_cast<int>(types.size()) == n) return !problem_.library().complete(types) || look_at(types);
    for (const int k : problem_.library().successors(types)) {
      types.push_back(k);
      const bool proved = extend(types, n);
      types.pop_back();
      if (!proved) return false;
    }
    return true;
  }

  [[nodiscard]] bool look_at(const std::vector<int>& types) {
    const certify::SequenceModel model{problem_, types};
    const double head = certify::score_of(problem_, types, 0.0);
    if (certify::out_of_reach(model, scenery_, head, weight_, upper_)) return true;
    std::string names;
    for (const int k : types) {
      names += fmt::format("{}{}", names.empty() ? "" : ",", json_text(problem_.library().type(k).id));
    }
    if (!model.fits()) {
      open_ = fmt::format("the arms of [{}] have too many lengths or joints", names);
      return false;
    }
    double cut = kInfinity;
    if (weight_ > 0.0 && upper_ > -kInfinity) {
      constexpr double kRounding = 2e-7;  // as in the search
      cut = (head - upper_) / weight_;
      cut += kRounding * std::abs(cut);
    }
    certify::SequenceTree* searched = search_.tree(types);
    const certify::ProofOutcome outcome =
        searched != nullptr ? searched->proof(cut, stop_) : certify::prove_sequence(model, scenery_, cut, stop_);
    leaves_ += outcome.leaves;
    if (!outcome.whole) {
      in_time_ = outcome.in_time;
      open_ = fmt::format("[{}]: {}", names, outcome.open);
      return false;
    }
    text_ += fmt::format("{}{{\"types\":[{}],\"tree\":{}}}", text_.empty() ? "" : ",\n", names, outcome.nodes);
    ++n_sequences_;
    return true;
  }

  const RobotProblem& problem_;
  certify::BoundSearch& search_;
  certify::Scenery scenery_;
  double weight_;
  double upper_ = 0.0;
  Meter& meter_;
  std::function<bool()> stop_;
  std::string open_;
  bool in_time_ = true;
  std::string text_;
  std::int64_t leaves_ = 0;
  std::int64_t n_sequences_ = 0;
};

std::string file_text(const RobotProblem& problem, const CertificateNames& names, const Certificate& certificate,
                      const std::optional<certify::Witness>& witness, const std::string& sequences) {
  std::string text = fmt::format("{{\"modsearch\":1,\n\"problem\":{}", json_text(names.problem));
  if (names.instance) {
    text += fmt::format(",\n\"instance\":{{\"seed\":{},\"index\":{}}}", names.instance->seed, names.instance->index);
  }
  text += fmt::format(",\n\"statement\":{},\n\"claim\":{{", statement(problem, names.scoring));
  if (certificate.upper == -kInfinity) {
    text += "\"unreachable\":true";
  } else {
    text += fmt::format("\"upper\":{:.17g}", certificate.upper);
    if (witness) text += fmt::format(",\"lower\":{:.17g},\"gap\":{:.17g}", *certificate.lower, *certificate.gap);
  }
  text += "}";
  if (witness) text += fmt::format(",\n\"incumbent\":{}", incumbent(problem, *witness));
  return fmt::format("{},\n\"sequences\":[\n{}\n]}}\n", text, sequences);
}

// A bound that no design of more than `n` modules exceeds, and nearly all others would.
double above_fewer(const RobotProblem& problem, int n) {
  double best = -kInfinity;
  for (int more = n + 1; more < problem.max_modules(); ++more) {
    best = std::max(best, problem.optimism_of_length(more).score);
  }
  return best + 1e-6;
}

// Boxes that are open close faster than others, half as fast as they came, say.
bool time_to_prove(const certify::BoundSearch& search, const Meter& meter) {
  const double spent = meter.progress().seconds;
  const auto open = static_cast<double>(search.n_open());
  const auto seen = static_cast<double>(2 * search.expanded() + 1);
  return spent * (1.0 + 0.5 * std::min(1.0, open / seen)) > 0.9 * meter.budget().seconds;
}

// Searches for a design that scores more than all of more modules do: it refutes the claim.
Certificate refuted_or_to_prove(certify::BoundSearch& search, double floor, Meter& meter) {
  const auto refuted = [&] { return search.best_witness() && search.best_witness()->score > floor; };
  while (!search.step(meter) && !refuted() && !time_to_prove(search, meter)) {
  }
  Certificate certificate{.upper = floor, .closed = true};
  if (!refuted()) return certificate;
  const certify::Witness& witness = *search.best_witness();
  const std::size_t n = witness.design.modules.size();
  certificate.closed = false;
  certificate.open = fmt::format("a design of {} module{} does: it scores {:.9g}", n, n == 1 ? "" : "s", witness.score);
  certificate.refuted_by = witness.design;
  return certificate;
}

// Searches; what is to be proved is what it ends with.
Certificate claim_of(const RobotProblem& problem, certify::BoundSearch& search, double gap, Meter& meter) {
  bool in_time = true;
  while (in_time && !search.step(meter)) in_time = !time_to_prove(search, meter);
  in_time = in_time && !meter.stopped();
  const std::optional<certify::Witness>& witness = search.best_witness();
  Certificate certificate{.upper = search.upper(meter), .closed = search.closed()};
  if (certificate.closed) {
    // Designs that the search has evaluated beside the witness are no better.
    certificate.upper = witness ? witness->score + gap * certify::unit_of_gap(problem, *witness) : -kInfinity;
    return certificate;
  }
  certificate.open = in_time ? "some boxes do not close, however small they are cut" : "the time was up";
  // A little above what the search got to, so that the proof gets there with room to spare.
  if (witness) certificate.upper += 0.02 * (certificate.upper - witness->score);
  return certificate;
}

// Writes the proof of the certificate's bound, or of the next looser one that is a proof.
void prove(const RobotProblem& problem, const CertificateNames& names, const std::optional<certify::Witness>& witness,
           certify::BoundSearch& search, Meter& meter, Certificate& certificate) {
  constexpr int kAttempts = 12;    // each time with twice the gap
  constexpr double kLeast = 5e-7;  // of the gap, which rounding takes a part of
  const double unit = witness ? certify::unit_of_gap(problem, *witness) : 1.0;
  Proof proof{problem, search, meter};
  for (int attempt = 1;; ++attempt) {
    if (witness) {
      certificate.lower = witness->score;
      certificate.of_mass = problem.spec().scoring->mass_weight() * witness->mass > 0.0;
      certificate.gap = (certificate.upper - witness->score) / unit;
    }
    if (proof.run(certificate.upper)) break;
    certificate.open = proof.open();
    certificate.closed = false;
    if (!witness || !proof.in_time() || attempt == kAttempts) return;
    certificate.upper = witness->score + 2.0 * std::max(certificate.upper - witness->score, kLeast * unit);
  }
  certificate.leaves = proof.leaves();
  certificate.sequences = proof.n_sequences();
  certificate.json = file_text(problem, names, certificate, witness, proof.sequences());
}

}  // namespace

Certificate make_certificate(const RobotProblem& problem, const CertifyOptions& options, const CertificateNames& names,
                             Meter& meter) {
  if (!(options.gap > 0.0 && options.gap <= 1.0)) {
    throw std::invalid_argument(fmt::format("gap is {}, not in (0, 1]", options.gap));
  }
  if (options.fewer && !(*options.fewer >= 0 && *options.fewer < problem.max_modules() - 1)) {
    throw std::invalid_argument(fmt::format("at most {} modules are to be proved too few, not in [0, {}]",
                                            *options.fewer, problem.max_modules() - 2));
  }
  if (const std::optional<std::string> why = certify::why_not_covered(problem)) {
    throw std::invalid_argument(fmt::format("nothing is proved about problem {}: {}", problem.name(), *why));
  }

  const double floor = options.fewer ? above_fewer(problem, *options.fewer) : -kInfinity;
  certify::BoundSearch search{problem, {.gap = options.gap, .recorded = true, .floor = floor}};
  Certificate certificate =
      options.fewer ? refuted_or_to_prove(search, floor, meter) : claim_of(problem, search, options.gap, meter);
  certificate.boxes = search.expanded();
  if (certificate.upper == kInfinity || certificate.refuted_by) return certificate;
  const std::optional<certify::Witness> witness = options.fewer ? std::nullopt : search.best_witness();
  prove(problem, names, witness, search, meter, certificate);
  return certificate;
}

}  // namespace modsearch
