#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <modsearch/problem/builtin_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/study/study_file.hpp>

namespace modsearch {
namespace {

using detail::JsonCursor;

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr int kMostInstances = 100'000;
constexpr int kMostSeeds = 10'000;

// Reads one study; knows where its files lie and what its names mean.
class Reader {
 public:
  explicit Reader(const StudyNames& names) : names_{names} {}

  [[nodiscard]] Study study(const JsonCursor& cursor) const {
    cursor.expect_keys({"modsearch", "name", "problems", "solvers", "seeds", "budget", "targets", "certify"});
    static_cast<void>(cursor.at("modsearch").integer(1, 1));
    Study study;
    study.name = cursor.at("name").text();
    for (const JsonCursor& entry : cursor.at("problems").items()) study.problems.push_back(problem(entry));
    for (const JsonCursor& entry : cursor.at("solvers").items()) {
      study.solvers.push_back(solver(entry, cursor.at("problems").items()));
    }
    study.seeds = seeds(cursor.at("seeds"));
    study.budget = budget(cursor.at("budget"));
    if (const auto entry = cursor.find("targets")) study.mass_targets = targets(*entry);
    if (const auto entry = cursor.find("certify")) study.certification = certification(*entry);
    static_cast<void>(cursor.guard([&] { return cells_of(study); }));
    return study;
  }

 private:
  // The problem with this name, as it can be loaded from here.
  [[nodiscard]] static std::string located(const JsonCursor& cursor) {
    const std::string name = cursor.text();
    return detail::builtin_problem(name) ? name : (cursor.source().directory / name).string();
  }

  // Complaints about a file that the study refers to name the study first.
  template <typename Load>
  [[nodiscard]] static auto referred(const JsonCursor& cursor, Load&& load) {
    try {
      return cursor.guard(load);
    } catch (const FileError& error) {
      const std::string what = error.what();
      if (what.starts_with(cursor.source().label)) throw;
      cursor.fail(what);
    }
  }

  [[nodiscard]] static StudyProblem problem(const JsonCursor& cursor) {
    cursor.expect_keys({"problem", "instances"});
    const JsonCursor name = cursor.at("problem");
    const auto entry = cursor.find("instances");
    const std::optional<InstanceRange> range = entry ? std::optional{instances(*entry)} : std::nullopt;
    StudyProblem problem = referred(name, [&] { return study_problem(located(name), range); });
    problem.name = name.text();
    return problem;
  }

  [[nodiscard]] static InstanceRange instances(const JsonCursor& cursor) {
    cursor.expect_keys({"seed", "first", "count"});
    InstanceRange range;
    range.seed = cursor.at("seed").unsigned_integer();
    if (const auto first = cursor.find("first")) range.first = first->unsigned_integer();
    range.count = static_cast<int>(cursor.at("count").integer(1, kMostInstances));
    check_range(cursor, range.first, static_cast<std::uint64_t>(range.count));
    return range;
  }

  // Refuses `count` numbers from `first` on where their sum would wrap.
  static void check_range(const JsonCursor& cursor, std::uint64_t first, std::uint64_t count) {
    constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max();
    if (count - 1 <= kLast - first) return;
    cursor.fail(fmt::format("{} numbers from {} on end above the largest, {}", count, first, kLast));
  }

  [[nodiscard]] StudySolver solver(const JsonCursor& cursor, const std::vector<JsonCursor>& problems) const {
    cursor.expect_keys({"solver", "label", "train", "refine"});
    const JsonCursor text = cursor.at("solver");
    StudySolver result;
    if (const auto refine = cursor.find("refine")) result.refine = refine->boolean();
    const char* const then = result.refine ? ", refined" : "";
    if (const auto train = cursor.find("train")) {
      if (text.text() != "policy") text.fail_value("\"policy\", which is what is trained");
      train->expect_keys({"agent", "episodes", "seeds", "on"});
      if (const auto on = train->find("on")) {
        add_training(*train, *on, result);
      } else {
        for (const JsonCursor& entry : problems) add_training(*train, entry.at("problem"), result);
      }
      result.label = cursor.text_or("label", train->at("agent").text() + then);
      return result;
    }
    StudyNames::NamedSolver named = referred(text, [&] { return names_.solver(text.text()); });
    result.label = cursor.text_or("label", text.text() + then);
    result.text = std::move(named.text);
    result.solver = std::move(named.solver);
    return result;
  }

  // Trains the solver's agent on the problem `on`, too.
  void add_training(const JsonCursor& cursor, const JsonCursor& on, StudySolver& solver) const {
    const JsonCursor agent = cursor.at("agent");
    ProblemFile family = referred(on, [&] { return load_problem_file(located(on)); });
    StudyNames::NamedAgent named = referred(agent, [&] { return names_.agent(agent.text(), family); });
    solver.text = std::move(named.text);
    StudyTraining training;
    training.settings = std::move(named.settings);
    if (const auto episodes = cursor.find("episodes")) {
      training.settings.training.episodes = episodes->integer(1, kMost);
      solver.text += fmt::format(" episodes={}", training.settings.training.episodes);
    }
    if (const auto list = cursor.find("seeds")) {
      training.seeds.clear();
      for (const JsonCursor& seed : list->items()) training.seeds.push_back(seed.unsigned_integer());
    }
    training.preset = std::move(named.preset);
    training.problem = on.text();
    training.library = family.spec.library;
    training.source = problem_source(std::move(family));
    solver.trainings.push_back(std::move(training));
  }

  [[nodiscard]] static std::vector<std::uint64_t> seeds(const JsonCursor& cursor) {
    cursor.expect_keys({"first", "count"});
    const std::uint64_t first = cursor.at("first").unsigned_integer();
    std::vector<std::uint64_t> list(static_cast<std::size_t>(cursor.at("count").integer(1, kMostSeeds)));
    check_range(cursor, first, list.size());
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = first + i;
    return list;
  }

  [[nodiscard]] static Budget budget(const JsonCursor& cursor) {
    cursor.expect_keys({"evaluations", "seconds"});
    if (!cursor.has("evaluations") && !cursor.has("seconds")) {
      cursor.fail("neither \"evaluations\" nor \"seconds\": a run would never end");
    }
    Budget budget{.evaluations = kMost};
    if (const auto evaluations = cursor.find("evaluations")) budget.evaluations = evaluations->integer(1, kMost);
    if (const auto seconds = cursor.find("seconds"))
      budget.seconds = seconds->number({.lower = 0.0, .above_lower = true});
    return budget;
  }

  [[nodiscard]] static std::vector<double> targets(const JsonCursor& cursor) {
    cursor.expect_keys({"mass"});
    std::vector<double> shares;
    for (const JsonCursor& share : cursor.at("mass").items()) {
      shares.push_back(share.number({.lower = 0.0, .above_lower = true}));
    }
    std::sort(shares.begin(), shares.end(), std::greater<>{});
    return shares;
  }

  [[nodiscard]] StudyCertification certification(const JsonCursor& cursor) const {
    cursor.expect_keys({"gap", "seconds"});
    const double gap = cursor.at("gap").number({.lower = 0.0, .above_lower = true});
    StudyCertification result;
    StudyNames::NamedSolver named =
        referred(cursor, [&] { return names_.solver(fmt::format("branch-and-bound:gap={}", gap)); });
    result.text = std::move(named.text);
    result.solver = std::move(named.solver);
    result.budget = {.evaluations = kMost, .seconds = cursor.at("seconds").number({.lower = 0.0, .above_lower = true})};
    return result;
  }

  const StudyNames& names_;
};

std::optional<std::string_view> builtin_study(std::string_view id) {
  for (const detail::BuiltinFile& file : detail::kBuiltinStudies) {
    if (file.id == id) return file.text;
  }
  return std::nullopt;
}

}  // namespace

Study load_study(const std::string& file_or_id, const StudyNames& names) {
  const Reader reader{names};
  if (const std::optional<std::string_view> text = builtin_study(file_or_id)) {
    const detail::JsonDocument document = detail::parse_json(std::string{*text}, {"built-in study " + file_or_id, {}});
    return reader.study(document.cursor());
  }
  detail::require_file_or_id(file_or_id, "study", builtin_studies());
  return reader.study(detail::load_json(file_or_id).cursor());
}

std::vector<std::string> builtin_studies() {
  std::vector<std::string> ids;
  for (const detail::BuiltinFile& file : detail::kBuiltinStudies) ids.emplace_back(file.id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace modsearch
