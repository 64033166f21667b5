#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "app/arguments.hpp"
#include "app/commands.hpp"
#include "app/interrupt.hpp"
#include "app/output_internal.hpp"
#include "app/standard_streams.hpp"

namespace {

using namespace modsearch;
using namespace modsearch::app;

// The command line as a shell would take it, for records.
std::string typed(int argc, char** argv) {
  std::string text = "modsearch";
  for (int i = 1; i < argc; ++i) text += ' ' + shell_word(argv[i]);
  return text;
}

struct Arguments {
  CommonArguments common;
  SolveArguments solve;
  TrainArguments train;
  CompareArguments compare;
  EvaluateArguments evaluate;
  VerifyArguments verify;
  RenderArguments render;
  ConvertArguments convert;
  GenerateArguments generate;
  CertifyArguments certify;
  CheckCertificateArguments check_certificate;
  BestKnownArguments best_known;
  ListArguments list;
};

void add_common(CLI::App& command, CommonArguments& common, const std::string& example) {
  command.add_flag("--json", common.json, "one JSON object on stdout");
  command.add_flag("--quiet", common.quiet, "no progress on stderr");
  command.footer("Example:\n  " + example);
}

void add_mesh_root(CLI::App& command, CommonArguments& common) {
  command
      .add_option_function<std::string>(
          "--mesh-root",
          [&](const std::string& text) {
            if (!std::filesystem::is_directory(text)) {
              throw std::invalid_argument(fmt::format("--mesh-root {}: there is no such folder", text));
            }
            common.files.mesh_root = text;
          },
          "folder in which meshes are looked for first, such as the top of a package of tasks")
      ->type_name("DIR");
}

void add_instance(CLI::App& command, std::optional<Instance>& instance) {
  command.add_option_function<std::string>(
      "--instance", [&](const std::string& text) { instance = parse_instance(text); },
      "SEED:INDEX of a sampled problem (default 0:0)");
}

void add_seed(CLI::App& command, std::uint64_t& seed, const std::string& meaning) {
  command
      .add_option_function<std::string>(
          "--seed",
          [&](const std::string& text) {
            seed = parse_whole_number("--seed", text, std::numeric_limits<std::uint64_t>::max());
          },
          meaning)
      ->type_name("N");
}

void add_checkpoint_seconds(CLI::App& command, double& seconds) {
  command
      .add_option_function<std::string>(
          "--checkpoint-seconds",
          [&](const std::string& text) { seconds = parse_seconds("--checkpoint-seconds", text); },
          fmt::format("least time between two checkpoints [s] (default {:g}): what a crash may cost", seconds))
      ->type_name("S");
}

void add_count(CLI::App& command, const std::string& option, int& count, const std::string& meaning) {
  constexpr std::uint64_t kMost = 1'000'000;
  command
      .add_option_function<std::string>(
          option,
          [&count, option](const std::string& text) {
            count = static_cast<int>(parse_whole_number(option, text, kMost));
          },
          meaning)
      ->type_name("N");
}

void describe(CLI::App& app, Arguments& a) {
  app.require_subcommand(1);
  app.set_version_flag("--version", MODSEARCH_VERSION);
  app.footer(
      "Exit status: 0 success, 1 a negative result, 2 bad input or output that cannot be written, 3 internal failure, "
      "130 interrupted.");

  CLI::App& solve = *app.add_subcommand("solve", "solve one instance of a problem");
  solve.add_option("PROBLEM", a.solve.problem, "problem file, or the ID of a built-in one")->required();
  solve.add_option("--solver", a.solve.solver, "NAME[:key=value,...], see `modsearch list solvers`")
      ->capture_default_str();
  add_instance(solve, a.solve.instance);
  // The numbers are read here because CLI11 takes -1 and numbers that are too large for something else.
  solve
      .add_option_function<std::string>(
          "--evaluations",
          [&](const std::string& text) {
            constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
            a.solve.evaluations = static_cast<std::int64_t>(parse_whole_number("--evaluations", text, kMost));
          },
          "at most this many evaluations of the score")
      ->type_name("N");
  solve
      .add_option_function<std::string>(
          "--seconds", [&](const std::string& text) { a.solve.seconds = parse_seconds("--seconds", text); },
          "at most this long [s]; 30 without --evaluations")
      ->type_name("S");
  solve
      .add_option_function<std::string>(
          "--verify-seconds",
          [&](const std::string& text) { a.solve.verify_seconds = parse_seconds("--verify-seconds", text); },
          "at most this long for what follows the search, the verification of its answer [s]; what is left of "
          "--seconds "
          "and 1 more, 60 without --seconds")
      ->type_name("S");
  add_seed(solve, a.solve.seed, "of the solver's random numbers (default 0)");
  solve
      .add_option_function<std::string>(
          "--fidelity", [&](const std::string&) { a.solve.at_path_level = true; },
          "path: ask for a collision-free path, whatever the problem's own level")
      ->check(CLI::IsMember({"path"}));
  solve
      .add_option_function<std::string>(
          "--until", [&](const std::string&) { a.solve.until_achieved = true; },
          "achieved: end at the first design that is achieved, whatever its score")
      ->check(CLI::IsMember({"achieved"}));
  solve.add_flag("--refine", a.solve.refine,
                 "afterwards solve for the lengths of the modules that were found, from eight starts, with what is "
                 "left of the budget");
  CLI::Option* checkpoint =
      solve.add_option("--checkpoint", a.solve.checkpoint, "FILE in which the search is kept while it runs");
  add_checkpoint_seconds(solve, a.solve.checkpoint_seconds);
  solve.add_flag("--resume", a.solve.resume, "go on from the checkpoint, if there is one")->needs(checkpoint);
  solve.add_option("--out", a.solve.out, "folder for solution.json, trace.csv and view.html");
  add_mesh_root(solve, a.common);
  add_common(solve, a.common, "modsearch solve seed/fixed --solver per-sequence:inner=ipopt --out out/");

  CLI::App& train = *app.add_subcommand("train", "train an agent on a problem, or on the instances of a sampled one");
  train.add_option("PROBLEM", a.train.problem, "problem file, or the ID of a built-in one")->required();
  train.add_option("--agent", a.train.agent, "NAME[:key=value,...], see `modsearch list agents`")
      ->capture_default_str();
  train
      .add_option_function<std::string>(
          "--episodes",
          [&](const std::string& text) {
            constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
            a.train.episodes = static_cast<std::int64_t>(parse_whole_number("--episodes", text, kMost));
          },
          "training episodes at most, instead of the preset's")
      ->type_name("N");
  add_seed(train, a.train.seed, "of weights, exploration and instances (default 0)");
  add_checkpoint_seconds(train, a.train.checkpoint_seconds);
  train.add_flag("--resume", a.train.resume, "go on from the checkpoint in --out");
  train.add_option("--out", a.train.out,
                   "folder for policy.json with its weights, training.csv, TensorBoard events, checkpoint.bin");
  add_mesh_root(train, a.common);
  add_common(train, a.common, "modsearch train seed/fixed --agent mpdqn:preset=best --out out/");

  CLI::App& compare =
      *app.add_subcommand("compare", "compare solvers and agents: problems x instances x solvers x seeds");
  compare.add_option("STUDY", a.compare.study, "study file, or the ID of a built-in one")->required();
  add_count(compare, "--jobs", a.compare.jobs, "cells at the same time, each in a process of its own (default 1)");
  compare.add_flag("--resume", a.compare.resume, "go on with the journal in --out");
  add_count(compare, "--recheck", a.compare.recheck, "finished cells to compute once more and compare (default 0)");
  compare.add_option("--out", a.compare.out, "folder for events.jsonl, runs.csv, traces.csv, report.html, policies/")
      ->required();
  add_common(compare, a.common, "modsearch compare quick --jobs 2 --out out/");

  CLI::App& evaluate = *app.add_subcommand("evaluate", "score a given design, term by term");
  evaluate.add_option("PROBLEM", a.evaluate.problem, "problem file or ID")->required();
  evaluate.add_option("DESIGN", a.evaluate.design, "solution file, or a JSON array of placements")->required();
  add_instance(evaluate, a.evaluate.instance);
  add_mesh_root(evaluate, a.common);
  add_common(evaluate, a.common, "modsearch evaluate seed/fixed design.json");

  CLI::App& verify = *app.add_subcommand("verify", "re-evaluate a solution from scratch, with its path");
  verify.add_option("SOLUTION", a.verify.solution, "solution file")->required();
  verify.add_option("--problem", a.verify.problem, "problem file or ID instead of the one named in the file");
  add_mesh_root(verify, a.common);
  add_common(verify, a.common, "modsearch verify out/solution.json");

  CLI::App& render = *app.add_subcommand("render", "make the 3-D page of a solution");
  render.add_option("SOLUTION", a.render.solution, "solution file")->required();
  render.add_option("--problem", a.render.problem, "problem file or ID instead of the one named in the file");
  render.add_option("--out", a.render.out, "folder for view.html; without it the page goes to stdout");
  add_mesh_root(render, a.common);
  add_common(render, a.common, "modsearch render out/solution.json --out out/");

  CLI::App& convert = *app.add_subcommand("convert", "write a library, task, problem, solution or design otherwise");
  convert.add_option("IN", a.convert.in, "file, or the ID of a built-in library or problem; its kind is seen")
      ->required();
  convert.add_option("OUT", a.convert.out, "file to write; what it refers to is named relative to it")->required();
  convert.add_option("--to", a.convert.to, "default: urdf where OUT ends so, else modsearch")
      ->check(CLI::IsMember({"modsearch", "timor", "cobra", "urdf"}));
  convert.add_option("--library", a.convert.library, "library, file or ID, of a design that names none");
  add_mesh_root(convert, a.common);
  add_common(convert, a.common, "modsearch convert out/solution.json arm.urdf");

  CLI::App& generate = *app.add_subcommand("generate", "write tasks of a family, each with its problem");
  generate.add_option("FAMILY", a.generate.family, "whitman: poses to reach among boxes")
      ->required()
      ->check(CLI::IsMember({"whitman"}));
  add_count(generate, "--goals", a.generate.goals, "goals of each task (default 3)");
  add_count(generate, "--boxes", a.generate.boxes, "boxes of each task (default 3)");
  generate.add_flag("--free-ends", a.generate.free_ends,
                    "draw goals again until some end effector is 5 mm free of the boxes there");
  add_seed(generate, a.generate.seed, "of the family (default 0)");
  add_count(generate, "--count", a.generate.count, "number of tasks (default 100)");
  generate.add_option("--out", a.generate.out, "folder for task_000.json, problem_000.json, ..")->required();
  add_common(generate, a.common, "modsearch generate whitman --goals 3 --boxes 3 --seed 0 --count 100 --out tasks/");

  CLI::App& certify = *app.add_subcommand("certify", "find the best design and prove how much better another can be");
  certify.add_option("PROBLEM", a.certify.problem, "problem file, or the ID of a built-in one")->required();
  add_instance(certify, a.certify.instance);
  certify.add_option("--gap", a.certify.gap, "share of the mass that may be left open, in (0, 1]")
      ->capture_default_str();
  certify
      .add_option_function<std::string>(
          "--seconds,--max-seconds",
          [&](const std::string& text) { a.certify.seconds = parse_seconds("--seconds", text); },
          "at most this long [s] (default 120); what is proved until then is what the certificate says")
      ->type_name("S");
  certify
      .add_option_function<std::string>(
          "--fewer",
          [&](const std::string& text) { a.certify.fewer = static_cast<int>(parse_whole_number("--fewer", text, 64)); },
          "instead: prove that no design of at most N modules (without the base) is achieved")
      ->type_name("N");
  certify.add_option("--out", a.certify.out, "FILE of the certificate")->capture_default_str();
  add_mesh_root(certify, a.common);
  add_common(certify, a.common, "modsearch certify seed/fixed --out out/certificate.json");

  CLI::App& check =
      *app.add_subcommand("check-certificate", "check a certificate with the independent modsearch-check");
  check.add_option("FILE", a.check_certificate.file, "certificate")->required();
  add_common(check, a.common, "modsearch check-certificate out/certificate.json");

  CLI::App& best_known =
      *app.add_subcommand("best-known", "verify designs and keep the better ones in the tables of best known designs");
  best_known.add_option("FILE", a.best_known.files, "solution files, and tables of designs")->required();
  best_known.add_option("--tables", a.best_known.tables, "folder of the tables, one file per family")
      ->capture_default_str();
  add_common(best_known, a.common, "modsearch best-known out/solution.json");

  CLI::App& list = *app.add_subcommand("list", "what there is, with options and defaults");
  list.add_option("WHAT", a.list.what, "solvers, agents, problems, libraries or studies")
      ->required()
      ->check(CLI::IsMember({"solvers", "agents", "problems", "libraries", "studies"}));
  add_common(list, a.common, "modsearch list solvers");
}

// CLI11 says of an unknown command, and of none, only that one is required.
void check_command(const CLI::App& app, int argc, char** argv) {
  if (argc > 1 && argv[1][0] == '-') return;
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    known.push_back(command->get_name());
  }
  if (argc < 2) throw std::invalid_argument(fmt::format("no command given: one of {}", fmt::join(known, ", ")));
  if (std::find(known.begin(), known.end(), argv[1]) != known.end()) return;
  throw std::invalid_argument(fmt::format("'{}' is not one of {}", argv[1], fmt::join(known, ", ")));
}

Status run(const CLI::App& app, const Arguments& a) {
  // Only a search can be asked to stop and still has something to say; everything else Ctrl-C simply ends.
  if (app.got_subcommand("solve")) return solve(a.solve, a.common, stop_on_interrupt());
  if (app.got_subcommand("train")) return train(a.train, a.common, stop_on_interrupt());
  if (app.got_subcommand("compare")) return compare(a.compare, a.common, stop_on_interrupt());
  if (app.got_subcommand("evaluate")) return evaluate(a.evaluate, a.common);
  if (app.got_subcommand("verify")) return verify_solution(a.verify, a.common);
  if (app.got_subcommand("render")) return render(a.render, a.common);
  if (app.got_subcommand("convert")) return convert(a.convert, a.common);
  if (app.got_subcommand("generate")) return generate(a.generate, a.common);
  if (app.got_subcommand("certify")) return certify(a.certify, a.common, stop_on_interrupt());
  if (app.got_subcommand("check-certificate")) return check_certificate(a.check_certificate, a.common);
  if (app.got_subcommand("best-known")) return best_known(a.best_known, a.common);
  return list(a.list, a.common);
}

int complain(Status status, const std::string& what) {
  tell_at_last(fmt::format("modsearch: {}\n", what));
  return static_cast<int>(status);
}

// What --help and --version print.
std::string answer_to(const CLI::App& app, const CLI::Success& asked) {
  const bool version = dynamic_cast<const CLI::CallForVersion*>(&asked) != nullptr;
  return version ? fmt::format("{}\n", asked.what()) : app.help();
}

int run_command(int argc, char** argv) {
  CLI::App app{"Modular robot design as a search problem."};
  app.name("modsearch");
  Arguments arguments;
  arguments.common.command = typed(argc, argv);
  describe(app, arguments);
  Status status = Status::kSuccess;
  try {
    check_command(app, argc, argv);
    app.parse(argc, argv);
    status = run(app, arguments);
  } catch (const CLI::Success& asked) {
    write_out(answer_to(app, asked));
  } catch (const CLI::ParseError& e) {
    return complain(Status::kBadInput, e.what());
  }
  flush_output();
  return static_cast<int>(status);
}

}  // namespace

int main(int argc, char** argv) {
  secure_standard_streams();
  try {
    return run_command(argc, argv);
  } catch (const FileError& e) {
    return complain(Status::kBadInput, e.what());
  } catch (const std::invalid_argument& e) {
    return complain(Status::kBadInput, e.what());
  } catch (const std::exception& e) {
    return complain(Status::kFailure, fmt::format("internal failure: {}", e.what()));
  }
}
