#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cfenv>
#include <cstdio>

#include "naive_certificate.hpp"
#include "places.hpp"

namespace modsearch_check {
namespace {

struct Outcome {
  int status = -1;
  std::string out;  // stdout and stderr
};

Outcome run(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("no pipe");
  Outcome outcome;
  char text[4096];
  for (std::size_t n = 0; (n = fread(text, 1, sizeof text, pipe)) > 0;) outcome.out.append(text, n);
  outcome.status = WEXITSTATUS(pclose(pipe));
  return outcome;
}

const std::string kFolder = std::filesystem::path{modsearch::test::command()}.parent_path().string();
const std::string kCheck = kFolder + "/modsearch-check ";

Json certificate_of_seed_fixed() {
  const Rounding up{FE_UPWARD};
  Json made = naive_certificate("seed/fixed", read_problem("seed/fixed", "", 0, 0), 341.94, 1);
  add_incumbent_of_seed_fixed(made);
  return made;
}

TEST(CheckCommand, ExplainsItself) {
  const Outcome help = run(kCheck + "--help");
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, testing::HasSubstr("usage: modsearch-check"));
  EXPECT_THAT(help.out, testing::HasSubstr("Example: "));
  EXPECT_EQ(run(kCheck).status, 2);
  EXPECT_EQ(run(kCheck + "--unknown").status, 2);
  EXPECT_EQ(run(kCheck + "a b").status, 2);
}

TEST(CheckCommand, SaysByItsExitStatusWhatItThinks) {
  const TemporaryFile file{"command.json"};
  Json certificate = certificate_of_seed_fixed();
  file.write(certificate.dump());
  const Outcome accepted = run(kCheck + file.path());
  EXPECT_EQ(accepted.status, 0);
  EXPECT_THAT(accepted.out, testing::StartsWith("accepted: seed/fixed"));

  const Json machine = Json::parse(run(kCheck + "--json " + file.path()).out);
  EXPECT_EQ(machine["verdict"], "accepted");
  EXPECT_EQ(machine["upper"], 341.94);
  EXPECT_EQ(machine["sequences"], 4) << "the base alone, and one of each of three types";

  certificate["sequences"].erase(0);
  file.write(certificate.dump());
  const Outcome rejected = run(kCheck + file.path());
  EXPECT_EQ(rejected.status, 1);
  EXPECT_EQ(rejected.out, "rejected: a sequence is missing: link\n");
  const Outcome for_machines = run(kCheck + "--json " + file.path());
  EXPECT_EQ(for_machines.status, 1);
  EXPECT_EQ(Json::parse(for_machines.out)["reason"], "a sequence is missing: link");

  file.write("{\n\"modsearch\": 1,\n}");
  const Outcome unreadable = run(kCheck + file.path());
  EXPECT_EQ(unreadable.status, 2);
  EXPECT_THAT(unreadable.out, testing::EndsWith(":3: is not JSON\n"));
  EXPECT_EQ(run(kCheck + file.path() + ".nowhere").status, 2);
  EXPECT_EQ(run(kCheck + "/dev/zero").status, 2);
}

}  // namespace
}  // namespace modsearch_check
