#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/problem/output_lock.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/solvers/verification.hpp>
#include <modsearch/study/best_known.hpp>
#include <tuple>

namespace modsearch {
namespace {

using detail::JsonCursor;
using nlohmann::ordered_json;

bool before(const Instance& a, const Instance& b) { return std::tie(a.seed, a.index) < std::tie(b.seed, b.index); }

Eigen::MatrixXd read_rows(const JsonCursor& cursor, std::size_t n_columns) {
  const std::vector<JsonCursor> items = cursor.items();
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(items.size()), static_cast<Eigen::Index>(n_columns));
  for (std::size_t i = 0; i < items.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = items[i].vector(n_columns).transpose();
  }
  return rows;
}

BestKnown read_entry(const JsonCursor& cursor, const RobotProblemSpec& spec) {
  cursor.expect_keys({"instance", "score", "design", "postures", "solver"});
  BestKnown entry;
  const JsonCursor instance = cursor.at("instance");
  instance.expect_keys({"seed", "index"});
  entry.instance = {instance.at("seed").unsigned_integer(), instance.at("index").unsigned_integer()};
  entry.score = cursor.at("score").number();
  entry.design = detail::read_design(cursor.at("design"), *spec.library);
  const auto n_joints = static_cast<std::size_t>(spec.library->assemble(entry.design.types()).n_joints());
  entry.postures = read_rows(cursor.at("postures"), n_joints);
  const JsonCursor solver = cursor.at("solver");
  solver.expect_keys({"name", "options", "seed", "evaluations", "seconds"});
  entry.solver = solver.at("name").text();
  for (const auto& [key, value] : solver.at("options").members()) entry.solver_options.emplace_back(key, value.text());
  entry.seed = solver.at("seed").unsigned_integer();
  entry.evaluations = solver.at("evaluations").integer(0, std::numeric_limits<std::int64_t>::max());
  entry.seconds = solver.at("seconds").number({.lower = 0.0});
  return entry;
}

BestKnownTable read_table(const JsonCursor& root) {
  root.expect_keys({"modsearch", "family", "designs"});
  static_cast<void>(root.at("modsearch").integer(1, 1));
  BestKnownTable table{.family = root.at("family").text()};
  if (!detail::builtin_problem(table.family)) root.at("family").fail_value("the ID of a built-in problem");
  const RobotProblemSpec spec = load_problem_file(table.family).spec;
  for (const JsonCursor& item : root.at("designs").items()) {
    table.entries.push_back(read_entry(item, spec));
    const std::size_t n = table.entries.size();
    if (n > 1 && !before(table.entries[n - 2].instance, table.entries[n - 1].instance)) {
      item.at("instance").fail("does not come after the one before it");
    }
  }
  return table;
}

bool is_table(const JsonCursor& root) { return root.value().is_object() && root.has("family"); }

// A design that somebody offers.
struct Offer {
  std::string file;
  BestKnown entry;
};

std::string offered_family(const LoadedSolution& solution, const std::filesystem::path& file) {
  if (detail::builtin_problem(solution.record.problem)) return solution.record.problem;
  throw FileError(fmt::format("{}: its problem \"{}\" is not built in, and tables name problems by their IDs",
                              file.string(), solution.record.problem));
}

BestKnown offered(const SolutionRecord& record) {
  return {.instance = record.instance.value_or(Instance{}),
          .score = record.evaluation.score,
          .design = record.design,
          .postures = record.evaluation.attempt.postures,
          .solver = record.solver,
          .solver_options = record.solver_options,
          .seed = record.seed,
          .evaluations = record.evaluations,
          .seconds = record.seconds};
}

using Offers = std::map<std::string, std::vector<Offer>>;  // by family

void read_offers(const std::filesystem::path& file, Offers& offers) {
  const detail::JsonDocument document = detail::load_json(file);
  if (!is_table(document.cursor())) {
    const LoadedSolution solution = load_solution(file);
    offers[offered_family(solution, file)].push_back({file.string(), offered(solution.record)});
    return;
  }
  BestKnownTable table = read_table(document.cursor());
  std::vector<Offer>& theirs = offers[table.family];
  for (BestKnown& entry : table.entries) theirs.push_back({file.string(), std::move(entry)});
}

// Why `entry` is not what it says; empty: it is.
std::string objection(const RobotProblem& problem, const BestKnown& entry) {
  Claims claims{.score = entry.score, .achieved = true};
  if (entry.postures.size() > 0) claims.postures = entry.postures;
  const Verification verification = verify(problem, entry.design, claims);
  if (verification.verified) return "";
  if (!verification.path_evaluation.attempt.achieved) {
    return fmt::format(
        "not achieved: {}",
        nearest_miss(problem.with_level(Level::kPath), entry.design, verification.path_evaluation).words());
  }
  return verification.findings.empty() ? "no path was found" : verification.findings.front();
}

void merge(BestKnownTable& table, const Offer& offer, BestKnownCounts& counts) {
  // Scores differ by rounding from one machine to another.
  constexpr double kSameScore = 1e-9;
  const auto at = std::lower_bound(table.entries.begin(), table.entries.end(), offer.entry.instance,
                                   [](const BestKnown& entry, const Instance& i) { return before(entry.instance, i); });
  const bool known = at != table.entries.end() && !before(offer.entry.instance, at->instance);
  if (!known) {
    table.entries.insert(at, offer.entry);
    ++counts.added;
  } else if (offer.entry.score > at->score + kSameScore * std::max(1.0, std::abs(at->score))) {
    *at = offer.entry;
    ++counts.improved;
  } else {
    ++counts.kept;
  }
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
}

}  // namespace

const BestKnown* BestKnownTable::find(const Instance& instance) const {
  const auto same = [&](const BestKnown& entry) {
    return entry.instance.seed == instance.seed && entry.instance.index == instance.index;
  };
  const auto found = std::find_if(entries.begin(), entries.end(), same);
  return found == entries.end() ? nullptr : &*found;
}

std::filesystem::path best_known_file(const std::filesystem::path& folder, const std::string& family) {
  return folder / (family + ".json");
}

BestKnownTable load_best_known(const std::filesystem::path& file) {
  const detail::JsonDocument document = detail::load_json(file);
  return read_table(document.cursor());
}

std::string best_known_to_json(const BestKnownTable& table) {
  const std::shared_ptr<const ModuleLibrary> library = load_problem_file(table.family).spec.library;
  ordered_json out{{"modsearch", 1}, {"family", table.family}, {"designs", ordered_json::array()}};
  for (const BestKnown& entry : table.entries) {
    ordered_json postures = ordered_json::array();
    for (Eigen::Index i = 0; i < entry.postures.rows(); ++i) {
      postures.push_back(detail::to_json(Eigen::VectorXd{entry.postures.row(i).transpose()}));
    }
    ordered_json options = ordered_json::object();
    for (const auto& [key, value] : entry.solver_options) options[key] = value;
    out["designs"].push_back({{"instance", {{"seed", entry.instance.seed}, {"index", entry.instance.index}}},
                              {"score", entry.score},
                              {"design", detail::to_json(*library, entry.design)},
                              {"postures", std::move(postures)},
                              {"solver",
                               {{"name", entry.solver},
                                {"options", std::move(options)},
                                {"seed", entry.seed},
                                {"evaluations", entry.evaluations},
                                {"seconds", entry.seconds}}}});
  }
  return detail::to_text(out);
}

BestKnownMerge merge_best_known(const std::filesystem::path& folder, std::span<const std::filesystem::path> files) {
  Offers offers;
  for (const std::filesystem::path& file : files) read_offers(file, offers);
  make_folder(folder);
  const OutputLock lock = OutputLock::of_folder(folder);  // what another merge adds meanwhile would be lost
  BestKnownMerge result;
  std::vector<std::pair<std::filesystem::path, std::string>> texts;
  for (const auto& [family, theirs] : offers) {
    const std::filesystem::path file = best_known_file(folder, family);
    BestKnownTable table{.family = family};
    if (std::filesystem::exists(file)) table = load_best_known(file);
    BestKnownCounts counts{.family = family};
    for (const Offer& offer : theirs) {
      const std::shared_ptr<const RobotProblem> problem = load_problem(family, offer.entry.instance);
      if (const std::string why = objection(*problem, offer.entry); !why.empty()) {
        result.refused.push_back(fmt::format("{}: the design for instance {}:{} of {} does not verify: {}", offer.file,
                                             offer.entry.instance.seed, offer.entry.instance.index, family, why));
        continue;
      }
      merge(table, offer, counts);
    }
    if (counts.added + counts.improved > 0) texts.emplace_back(file, best_known_to_json(table));
    result.counts.push_back(std::move(counts));
  }
  for (const auto& [file, text] : texts) {
    make_folder(file.parent_path());
    write_file(file, text);
    result.written.push_back(file);
  }
  return result;
}

}  // namespace modsearch
