#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/baselines/lexicographic.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/checker_process.hpp"
#include "app/chosen_problem_internal.hpp"
#include "app/commands.hpp"
#include "app/output_internal.hpp"

namespace modsearch::app {
namespace {

// "1 box", "2 boxes".
template <typename Number>
std::string plural(Number n, const std::string& one, const std::string& many = {}) {
  return fmt::format("{} {}", n, n == 1 ? one : many.empty() ? fmt::format("{}s", one) : many);
}

// The scoring as the problem's file has it: certificates repeat it.
std::string scoring_text(const std::string& problem) {
  if (is_builtin(problem)) return R"({"type":"algorithm1"})";
  std::ifstream stream{problem};
  return nlohmann::json::parse(stream).at("scoring").dump();
}

// What is proved, in one sentence.
std::string statement(const Certificate& certificate, const RobotProblem& problem, const CertifyArguments& arguments) {
  const bool obstacles = problem.spec().level != Level::kNone && !problem.scene().obstacles().empty();
  const std::string reaches = obstacles ? "reaches free of obstacles" : "reaches";
  const int most = problem.max_modules() - 1;
  const auto modules = [](int n) { return plural(n, "module"); };
  if (arguments.fewer) {
    return fmt::format("no design that {} scores above {}: all of at most {} would", reaches,
                       rounded_up(certificate.upper, 9), modules(*arguments.fewer));
  }
  if (std::isinf(certificate.upper)) {
    return certificate.upper < 0.0 ? fmt::format("no design of at most {} {}", modules(most), reaches) : "nothing yet";
  }
  return fmt::format("no design of at most {} that {} scores above {}", modules(most), reaches,
                     rounded_up(certificate.upper, 9));
}

std::string not_proved(const RobotProblem& problem) {
  std::string text = "torques, speeds, bodies of the arm that touch each other, paths between postures";
  switch (problem.spec().level) {
    case Level::kNone:
      return text + ", obstacles";
    case Level::kPosture:
      return text;
    case Level::kPostureSelf:
    case Level::kPath:
      return text + fmt::format(
                        "; the level {} forbids more than was proved, so the bound holds, and the design found need "
                        "not meet it",
                        name(problem.spec().level));
  }
  return text;
}

// The bound as it was claimed, once the checker has read what was written: a claim that it refuses is none.
struct Checked {
  bool accepted = false;
  std::string why_not{};
  double seconds = 0.0;
};

// Writes the certificate and has it checked; under its name it stands only once it is accepted.
Checked write_checked(const std::filesystem::path& out, const Certificate& certificate, double seconds,
                      std::stop_token stop) {
  if (certificate.json.empty()) return {.why_not = certificate.open};
  const std::filesystem::path unchecked = out.string() + ".unchecked";
  write_file(unchecked, certificate.json);
  const CheckerVerdict verdict = run_checker(unchecked, seconds, std::move(stop));
  if (verdict.kind != CheckerVerdict::Kind::kAccepted) {
    std::filesystem::remove(unchecked);
    const std::string_view who = verdict.kind == CheckerVerdict::Kind::kRefused ? "the checker refuses it: " : "";
    return {.why_not = fmt::format("{}{}", who, verdict.reason), .seconds = verdict.seconds};
  }
  std::filesystem::rename(unchecked, out);
  return {.accepted = true, .seconds = verdict.seconds};
}

}  // namespace

Status certify(const CertifyArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  if (arguments.out.empty()) throw std::invalid_argument("--out is empty: not the name of a file");
  const ChosenProblem chosen = choose_problem(arguments.problem, arguments.instance, common.files);
  const RobotProblem& problem = *chosen.problem;
  if (std::filesystem::is_directory(arguments.out) || !arguments.out.has_filename()) {
    throw std::invalid_argument(fmt::format("--out {}: is a folder, not the name of a file", arguments.out.string()));
  }
  const std::filesystem::path folder = std::filesystem::absolute(arguments.out).parent_path();
  make_folder(folder);
  const OutputLock lock = OutputLock::of_file(arguments.out);
  constexpr double kSeconds = 120.0;  // without --seconds: memory grows with the boxes that are open
  const double seconds = arguments.seconds.value_or(kSeconds);
  Meter meter{{.evaluations = std::numeric_limits<std::int64_t>::max(), .seconds = seconds}, {}, stop};
  const Certificate certificate = make_certificate(
      problem, {.gap = arguments.gap, .fewer = arguments.fewer},
      {problem_reference(arguments.problem, folder), chosen.instance, scoring_text(arguments.problem)}, meter);
  const double taken = meter.progress().seconds;
  const Checked checked = write_checked(arguments.out, certificate, std::max(kSeconds, seconds), stop);
  const bool interrupted = stop.stop_requested();
  const bool proved = checked.accepted;
  const std::string& open = proved ? certificate.open : checked.why_not;
  const bool closed = proved && certificate.closed;
  if (common.json) {
    nlohmann::ordered_json json{{"problem", arguments.problem}, {"proved", proved}, {"closed", closed}};
    if (std::isfinite(certificate.upper)) json["upper"] = certificate.upper;
    if (certificate.upper == -std::numeric_limits<double>::infinity()) json["unreachable"] = true;
    if (certificate.lower) json["lower"] = *certificate.lower;
    if (certificate.gap) json["gap"] = *certificate.gap;
    json["open"] = open;
    json["notProved"] = not_proved(problem);
    json["boxes"] = certificate.boxes;
    json["sequences"] = certificate.sequences;
    json["leaves"] = certificate.leaves;
    json["bytes"] = certificate.json.size();
    json["seconds"] = taken;
    json["checkSeconds"] = checked.seconds;
    if (proved) json["file"] = arguments.out.string();
    print(json);
  } else {
    say("{}{}\n", proved ? "proved       " : "not proved   ", statement(certificate, problem, arguments));
    if (certificate.lower) {
      say("found        one that does so scores {:.9g}\n", *certificate.lower);
      say("interval     [{:.9g}, {:.9g}], {:.3g} % of the {}\n", *certificate.lower, certificate.upper,
          100.0 * *certificate.gap, certificate.of_mass ? "mass" : "score");
    }
    if (!open.empty()) say("open         {}\n", interrupted ? "interrupted" : open);
    say("no part      {}\n", not_proved(problem));
    say("search       {}; {} in {}, {:.3f} s\n", plural(certificate.boxes, "box", "boxes"),
        plural(certificate.leaves, "leaf", "leaves"), plural(certificate.sequences, "type sequence"), taken);
    if (proved) {
      say("checked      accepted by modsearch-check in {:.3f} s\n", checked.seconds);
      say("wrote        {} ({} bytes); to check it again: modsearch check-certificate {}\n", arguments.out.string(),
          certificate.json.size(), shell_word(arguments.out.string()));
    } else {
      say("wrote        nothing\n");
    }
  }
  if (interrupted) return Status::kInterrupted;
  return closed ? Status::kSuccess : Status::kNegative;
}

Status check_certificate(const CheckCertificateArguments& arguments, const CommonArguments& common) {
  const std::string program = checker_program().string();
  std::string name = "modsearch-check";
  std::string json = "--json";
  std::string file = arguments.file;
  flush_output();
  char* with_json[] = {name.data(), json.data(), file.data(), nullptr};
  char* without[] = {name.data(), file.data(), nullptr};
  ::execv(program.c_str(), common.json ? with_json : without);
  throw std::invalid_argument(fmt::format(
      "check-certificate: {}, which has to stand beside modsearch, cannot be run: {}", program, std::strerror(errno)));
}

}  // namespace modsearch::app
