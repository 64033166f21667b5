#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <modsearch/baselines/certificate.hpp>
#include <nlohmann/json.hpp>

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
    return fmt::format("no design that {} scores above {:.9g}: all of at most {} would", reaches, certificate.upper,
                       modules(*arguments.fewer));
  }
  if (std::isinf(certificate.upper)) {
    return certificate.upper < 0.0 ? fmt::format("no design of at most {} {}", modules(most), reaches) : "nothing yet";
  }
  return fmt::format("no design of at most {} that {} scores above {:.9g}", modules(most), reaches, certificate.upper);
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

}  // namespace

Status certify(const CertifyArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  if (arguments.out.empty()) throw std::invalid_argument("--out is empty: not the name of a file");
  const ChosenProblem chosen = choose_problem(arguments.problem, arguments.instance);
  const RobotProblem& problem = *chosen.problem;
  const std::filesystem::path folder = std::filesystem::absolute(arguments.out).parent_path();
  make_folder(folder);
  const OutputLock lock = OutputLock::of_file(arguments.out);
  constexpr double kSeconds = 120.0;  // without --seconds: memory grows with the boxes that are open
  const double seconds = arguments.seconds.value_or(kSeconds);
  Meter meter{{.evaluations = std::numeric_limits<std::int64_t>::max(), .seconds = seconds}, {}, stop};
  const Certificate certificate = make_certificate(
      problem, {.gap = arguments.gap, .fewer = arguments.fewer},
      {problem_reference(arguments.problem, folder), chosen.instance, scoring_text(arguments.problem)}, meter);
  if (!certificate.json.empty()) write_file(arguments.out, certificate.json);

  const bool interrupted = meter.stopped() == StopReason::kInterrupted;
  const double taken = meter.progress().seconds;
  const bool proved = !certificate.json.empty();
  if (common.json) {
    nlohmann::ordered_json json{{"problem", arguments.problem}, {"proved", proved}, {"closed", certificate.closed}};
    if (std::isfinite(certificate.upper)) json["upper"] = certificate.upper;
    if (certificate.upper == -std::numeric_limits<double>::infinity()) json["unreachable"] = true;
    if (certificate.lower) json["lower"] = *certificate.lower;
    if (certificate.gap) json["gap"] = *certificate.gap;
    json["open"] = certificate.open;
    json["notProved"] = not_proved(problem);
    json["boxes"] = certificate.boxes;
    json["sequences"] = certificate.sequences;
    json["leaves"] = certificate.leaves;
    json["bytes"] = certificate.json.size();
    json["seconds"] = taken;
    if (proved) json["file"] = arguments.out.string();
    print(json);
  } else {
    say("{}{}\n", proved ? "proved       " : "not proved   ", statement(certificate, problem, arguments));
    if (certificate.lower) {
      say("found        one that does so scores {:.9g}\n", *certificate.lower);
      say("interval     [{:.9g}, {:.9g}], {:.3g} % of the mass\n", *certificate.lower, certificate.upper,
          100.0 * *certificate.gap);
    }
    if (!certificate.open.empty()) say("open         {}\n", interrupted ? "interrupted" : certificate.open);
    say("no part      {}\n", not_proved(problem));
    say("search       {}; {} in {}, {:.3f} s\n", plural(certificate.boxes, "box", "boxes"),
        plural(certificate.leaves, "leaf", "leaves"), plural(certificate.sequences, "type sequence"), taken);
    if (proved) {
      say("wrote        {} ({} bytes); to check it: modsearch check-certificate {}\n", arguments.out.string(),
          certificate.json.size(), shell_word(arguments.out.string()));
    } else {
      say("wrote        nothing\n");
    }
  }
  if (interrupted) return Status::kInterrupted;
  return proved && certificate.closed ? Status::kSuccess : Status::kNegative;
}

Status check_certificate(const CheckCertificateArguments& arguments, const CommonArguments& common) {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (own.parent_path() / "modsearch-check").string();
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
