#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <modsearch/rl/event_file.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <modsearch/rl/training_csv.hpp>
#include <modsearch/solvers/archive.hpp>

#include "app/agent_choice.hpp"
#include "app/commands.hpp"
#include "app/output_internal.hpp"
#include "app/training_display.hpp"

namespace modsearch::app {
namespace {

constexpr const char* kCheckpoint = "checkpoint.bin";

double now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

// What a checkpoint must agree in with the training that goes on from it. The number of episodes may grow where it
// changes no schedule, so it is compared with the rest.
std::vector<std::string> identity(const TrainArguments& arguments, const LearnerSettings& settings) {
  std::vector<std::string> lines{"problem=" + arguments.problem, fmt::format("seed={}", arguments.seed),
                                 fmt::format("agent={}", name(settings.kind))};
  for (const Setting& setting : setting_table()) lines.push_back(setting.key + "=" + setting.get(settings));
  return lines;
}

void check_identity(const Archive& archive, const std::vector<std::string>& wanted) {
  const std::vector<std::string> found = archive.texts("training.identity");
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (i < found.size() && found[i] == wanted[i]) continue;
    archive.fail("training.identity", fmt::format("the checkpoint was made with {}, this training has {}",
                                                  i < found.size() ? found[i] : "other settings", wanted[i]));
  }
}

// Everything a training leaves in its folder.
class TrainingFiles {
 public:
  TrainingFiles(std::filesystem::path folder, std::vector<std::string> identity, bool resume, double period)
      : folder_{std::move(folder)},
        lock_{claim_folder(folder_)},
        identity_{std::move(identity)},
        period_{period},
        last_checkpoint_{now()} {
    if (resume) {
      checkpoint_ = Archive::load(folder_ / kCheckpoint);
      check_identity(*checkpoint_, identity_);
    } else if (std::filesystem::exists(folder_ / kCheckpoint)) {
      throw std::invalid_argument(
          fmt::format("--out {}: holds a training already; --resume goes on with it", folder_.string()));
    }
  }

  void begin(Trainer& trainer) {
    if (checkpoint_) trainer.load(*checkpoint_);
    checkpoint_.reset();
    const std::vector<EvaluationPoint>& history = trainer.history();
    csv_.emplace(folder_ / "training.csv", history);
    events_.emplace(folder_, now());
    // The checkpoint counts: what earlier files hold may go further than it, or be torn where a machine went down.
    events_->restart(0, now());
    for (const EvaluationPoint& point : history) add_scalars(point, now() - (history.back().seconds - point.seconds));
  }

  void add(const Trainer& trainer) {
    csv_->append(trainer.history().back());
    add_scalars(trainer.history().back(), now());
    if (now() - last_checkpoint_ >= period_) save(trainer);
  }

  void save(const Trainer& trainer) {
    Archive archive;
    archive.put("training.identity", identity_);
    trainer.save(archive);
    archive.save(folder_ / kCheckpoint);
    last_checkpoint_ = now();
  }

 private:
  void add_scalars(const EvaluationPoint& point, double time) {
    const auto scalar = [&](const char* tag, double value) { events_->scalar(tag, point.episode, value, time); };
    scalar("evaluation/return", point.evaluation.mean_return);
    scalar("evaluation/one_step", point.evaluation.one_step_share);
    scalar("evaluation/success", point.evaluation.success_share);
    scalar("training/return", point.training_return);
    scalar("training/value_loss", point.value_loss);
    scalar("training/epsilon", point.epsilon);
  }

  std::filesystem::path folder_;
  OutputLock lock_;
  std::vector<std::string> identity_;
  double period_;  // least time between two checkpoints [s]
  double last_checkpoint_;
  std::optional<Archive> checkpoint_;
  std::optional<TrainingCsv> csv_;
  std::optional<EventFile> events_;
};

bool has_finite_weights(const Policy& policy) {
  return std::all_of(policy.tensors().begin(), policy.tensors().end(), [](const auto& tensor) {
    return std::all_of(tensor.second.begin(), tensor.second.end(), [](float w) { return std::isfinite(w); });
  });
}

nlohmann::ordered_json summary_json(const TrainArguments& arguments, const ChosenAgent& chosen,
                                    const Training& training) {
  nlohmann::ordered_json json;
  json["problem"] = arguments.problem;
  json["agent"] = name(chosen.settings.kind);
  json["preset"] = chosen.preset;
  json["seed"] = arguments.seed;
  json["end"] = name(training.end);
  json["episodes"] = training.episodes;
  json["steps"] = training.steps;
  json["updates"] = training.updates;
  json["evaluations"] = training.spent.evaluations;
  json["seconds"] = training.seconds;
  const std::optional<std::int64_t> stabilised = stabilised_after(training.history);
  json["stabilisedAfter"] = stabilised ? nlohmann::ordered_json(*stabilised) : nlohmann::ordered_json(nullptr);
  const bool done = training.end == TrainingEnd::kEpisodes || training.end == TrainingEnd::kPatience;
  if (done && chosen.settings.training.final_episodes > 0) {
    const EvaluationSummary& e = training.final_evaluation;
    json["final"] = {{"episodes", chosen.settings.training.final_episodes},
                     {"meanReturn", e.mean_return},
                     {"deviation", e.deviation},
                     {"successShare", e.success_share},
                     {"oneStepShare", e.one_step_share},
                     {"meanSteps", e.mean_steps}};
  }
  return json;
}

std::string summary_text(const nlohmann::ordered_json& json) {
  std::string text = fmt::format("agent        {} on {}, preset {}, seed {}\n", json["agent"].get<std::string>(),
                                 json["problem"].get<std::string>(), json["preset"].get<std::string>(),
                                 json["seed"].get<std::uint64_t>());
  const auto episodes = json["episodes"].get<std::int64_t>();
  const double seconds = json["seconds"].get<double>();
  text += fmt::format("training     {} episodes, {} steps, {} updates, {:.2f} s", episodes,
                      json["steps"].get<std::int64_t>(), json["updates"].get<std::int64_t>(), seconds);
  if (episodes > 0)
    text += fmt::format(" ({:.2f} s per 1000 episodes)", 1000.0 * seconds / static_cast<double>(episodes));
  text += fmt::format("\nended        {}\n", json["end"].get<std::string>());
  text += json["stabilisedAfter"].is_null()
              ? std::string{"stabilised   never: no ten evaluations in a row were all one-step\n"}
              : fmt::format("stabilised   after {} episodes: ten evaluations in a row all one-step\n",
                            json["stabilisedAfter"].get<std::int64_t>());
  if (json.contains("final")) {
    const auto& final = json["final"];
    text +=
        fmt::format("final        mean return {:.4f} over {} greedy episodes, {:.1f} % reached, {:.1f} % in one step\n",
                    final["meanReturn"].get<double>(), final["episodes"].get<int>(),
                    100.0 * final["successShare"].get<double>(), 100.0 * final["oneStepShare"].get<double>());
  }
  return text;
}

}  // namespace

Status train(const TrainArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  if (arguments.resume && !arguments.out) throw std::invalid_argument("--resume needs --out, the folder to go on in");
  const ProblemFile file = load_problem_file(arguments.problem, common.files);
  ChosenAgent chosen = choose_agent(arguments.agent, file);
  if (arguments.episodes) chosen.settings.training.episodes = *arguments.episodes;
  std::optional<TrainingFiles> files;
  if (arguments.out) {
    files.emplace(*arguments.out, identity(arguments, chosen.settings), arguments.resume, arguments.checkpoint_seconds);
  }

  TrainingDisplay display{arguments.agent, common.quiet};
  const AgentLearner learner{chosen.settings,
                             {.begin =
                                  [&](Trainer& trainer) {
                                    if (files) files->begin(trainer);
                                  },
                              .observer =
                                  [&](const Trainer& trainer) {
                                    display.update(trainer);
                                    if (files) files->add(trainer);
                                    return true;
                                  },
                              .stop = [&] { return stop.stop_requested(); },
                              .ended =
                                  [&](const Trainer& trainer) {
                                    if (files) files->save(trainer);
                                  }}};
  Meter meter{{.evaluations = std::numeric_limits<std::int64_t>::max()}};
  const Training training = learner.train(problem_source(file), meter, Rng{arguments.seed});
  display.finish();

  nlohmann::ordered_json json = summary_json(arguments, chosen, training);
  const auto& policy = dynamic_cast<const Policy&>(*training.policy);
  const bool diverged = training.end == TrainingEnd::kDiverged || !has_finite_weights(policy);
  json["diverged"] = diverged;
  std::string text = summary_text(json);
  if (diverged)
    text += "diverged     the numbers left all bounds, so no policy is kept; smaller learning rates may help\n";
  if (arguments.out) {
    PolicyFile::Facts facts{.version = MODSEARCH_VERSION,
                            .preset = chosen.preset,
                            .seed = arguments.seed,
                            .episodes = json["episodes"].get<std::int64_t>(),
                            .steps = json["steps"].get<std::int64_t>(),
                            .updates = json["updates"].get<std::int64_t>(),
                            .seconds = json["seconds"].get<double>(),
                            .mean_return = std::nullopt};
    if (json.contains("final")) facts.mean_return = training.final_evaluation.mean_return;
    const std::filesystem::path path = *arguments.out / "policy.json";
    if (!diverged) {
      const std::string problem = problem_reference(arguments.problem, *arguments.out);
      write_policy(path, describe(policy, *file.spec.library, problem, facts));
      json["files"].push_back(path.string());
    }
    for (const char* name : {"training.csv", kCheckpoint}) json["files"].push_back((*arguments.out / name).string());
    for (const auto& written : json["files"]) text += fmt::format("wrote        {}\n", written.get<std::string>());
  } else {
    text += "not kept     the policy; --out FOLDER would keep it\n";
  }
  if (common.json) {
    print(json);
  } else {
    write_out(text);
  }
  if (training.end == TrainingEnd::kInterrupted) return Status::kInterrupted;
  return diverged ? Status::kNegative : Status::kSuccess;
}

}  // namespace modsearch::app
