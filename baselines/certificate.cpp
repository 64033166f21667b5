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

// Proves that no achieved design scores above `upper`, sequence by sequence, in the order of the checker.
class Proof {
 public:
  Proof(const RobotProblem& problem, double upper, Meter& meter)
      : problem_{problem},
        scenery_{certify::scenery_of(problem)},
        weight_{problem.spec().scoring->mass_weight()},
        upper_{upper},
        meter_{meter},
        stop_{[this] { return meter_.stopped().has_value(); }} {}

  // False: something is left open, see open().
  [[nodiscard]] bool run() {
    for (int n = 0; n < problem_.max_modules(); ++n) {
      if (best_of_length(n) <= upper_) continue;
      std::vector<int> types;
      if (!extend(types, n)) return false;
    }
    return true;
  }

  [[nodiscard]] const std::string& open() const { return open_; }
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
    certify::ProofOutcome outcome = certify::prove_sequence(model, scenery_, cut, stop_);
    leaves_ += outcome.leaves;
    if (!outcome.whole) {
      open_ = fmt::format("[{}]: {}", names, outcome.open);
      return false;
    }
    text_ += fmt::format("{}{{\"types\":[{}],\"tree\":{}}}", text_.empty() ? "" : ",\n", names, outcome.nodes);
    ++n_sequences_;
    return true;
  }

  const RobotProblem& problem_;
  certify::Scenery scenery_;
  double weight_;
  double upper_;
  Meter& meter_;
  std::function<bool()> stop_;
  std::string open_;
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

  Certificate certificate;
  std::optional<certify::Witness> witness;
  if (options.fewer) {
    certificate.upper = -kInfinity;
    for (int n = *options.fewer + 1; n < problem.max_modules(); ++n) {
      certificate.upper = std::max(certificate.upper, problem.optimism_of_length(n).score);
    }
    certificate.upper += 1e-6;
    certificate.closed = true;
  } else {
    certify::BoundSearch search{problem, options.gap};
    const double half = 0.5 * meter.budget().seconds;
    while (!search.step(meter) && meter.progress().seconds < half) {
    }
    certificate.boxes = search.expanded();
    certificate.closed = search.closed();
    witness = search.best_witness();
    certificate.upper = search.upper(meter);
    if (certificate.closed) {
      // Designs that the search has evaluated beside the witness are no better.
      certificate.upper = witness ? witness->score + options.gap * certify::unit_of_gap(problem, *witness) : -kInfinity;
    } else {
      certificate.open = meter.progress().seconds < half
                             ? "some boxes do not close, however small they are cut"
                             : "the time was up";
      // A little above what the search got to, so that the proof gets there with room to spare.
      if (witness) certificate.upper += 0.02 * (certificate.upper - witness->score);
    }
    if (certificate.upper == kInfinity) return certificate;
    if (witness) {
      certificate.lower = witness->score;
      certificate.gap = (certificate.upper - witness->score) / certify::unit_of_gap(problem, *witness);
    }
  }
  Proof proof{problem, certificate.upper, meter};
  if (!proof.run()) {
    certificate.open = proof.open();
    certificate.closed = false;
    return certificate;
  }
  certificate.leaves = proof.leaves();
  certificate.sequences = proof.n_sequences();
  certificate.json = file_text(problem, names, certificate, witness, proof.sequences());
  return certificate;
}

}  // namespace modsearch
