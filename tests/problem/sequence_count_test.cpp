#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <nlohmann/json.hpp>

#include "problem/temporary_folder.hpp"
#include "places.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;

/// A module without joints, entered by `in` and left by `out` (types of connectors).
ModuleType link(const std::string& id, const std::string& in, const std::string& out) {
  ModuleType module;
  module.id = module.name = id;
  module.bodies.resize(1);
  module.bodies[0].id = "body";
  module.bodies[0].connectors = {{"in", {}, Gender::kFemale, in, {1.0}}, {"out", {}, Gender::kMale, out, {1.0}}};
  return module;
}

ModuleType turning(const std::string& id, const std::string& in, const std::string& out) {
  ModuleType module = link(id, in, out);
  module.bodies.resize(2);
  module.bodies[1].id = "upper";
  module.bodies[1].connectors = {module.bodies[0].connectors[1]};
  module.bodies[0].connectors.resize(1);
  module.joints.resize(1);
  module.joints[0].joint.name = "joint";
  module.joints[0].child = 1;
  module.joints[0].joint.lower = -1.0;
  module.joints[0].joint.upper = 1.0;
  return module;
}

/// Two kinds of connectors, so that some modules do not fit.
ModuleLibrary two_kinds() {
  return ModuleLibrary{"two kinds",
                       {link("base", "base", "a"), link("aa", "a", "a"), link("ab", "a", "b"), turning("ba", "b", "a"),
                        turning("J", "a", "a"), link("tip", "b", "eef")}};
}

/// Every sequence of `n` types, fitting or not.
template <typename Visit>
void for_each_sequence(const ModuleLibrary& library, int n, std::vector<int>& types, const Visit& visit) {
  if (static_cast<int>(types.size()) == n) return visit(types);
  for (int k = 0; k < library.n_types(); ++k) {
    types.push_back(k);
    for_each_sequence(library, n, types, visit);
    types.pop_back();
  }
}

/// Whether types[i..] match pattern[part..], tried out in every way.
bool matches(const ModuleLibrary& library, std::span<const int> types, std::span<const PatternPart> pattern) {
  if (pattern.empty()) return types.empty();
  for (int count = 0; count <= pattern[0].most; ++count) {
    if (count >= pattern[0].least &&
        matches(library, types.subspan(static_cast<std::size_t>(count)), pattern.subspan(1))) {
      return true;
    }
    if (static_cast<int>(types.size()) <= count) return false;
    if (library.type(types[static_cast<std::size_t>(count)]).role() != pattern[0].role) return false;
  }
  return false;
}

TEST(SequenceCount, AgreesWithBuildingEverySequence) {
  const ModuleLibrary library = two_kinds();
  for (int n = 0; n <= 6; ++n) {
    SequenceCount expected;
    std::vector<int> types;
    for_each_sequence(library, n, types, [&](const std::vector<int>& sequence) {
      ++expected.all;
      if (!library.fits_together(sequence)) return;
      ++expected.fitting;
      if (library.complete(sequence)) ++expected.complete;
    });
    const SequenceCount count = count_sequences(library, n);
    EXPECT_EQ(count.all, expected.all) << n;
    EXPECT_EQ(count.fitting, expected.fitting) << n;
    EXPECT_EQ(count.complete, expected.complete) << n;
  }
}

TEST(SequenceCount, OfAPatternAgreesWithBuildingEverySequence) {
  const ModuleLibrary library = two_kinds();
  using enum ModuleRole;
  const std::vector<std::vector<PatternPart>> patterns{
      {{kJoint}, {kLink, 0, 2}, {kJoint}},
      {{kLink, 0, 2}, {kJoint, 0, 1}, {kLink, 0, 2}},  // two links match in three ways and count once
      {{kLink, 1, 3}, {kEndEffector}},
      {{kJoint, 0, 0}},
      {}};
  for (const std::vector<PatternPart>& pattern : patterns) {
    SequenceCount expected;
    for (int n = 0; n <= 5; ++n) {
      std::vector<int> types;
      for_each_sequence(library, n, types, [&](const std::vector<int>& sequence) {
        if (!matches(library, sequence, pattern)) return;
        ++expected.all;
        if (!library.fits_together(sequence)) return;
        ++expected.fitting;
        if (library.complete(sequence)) ++expected.complete;
      });
    }
    const SequenceCount count = count_sequences(library, pattern);
    EXPECT_EQ(count.all, expected.all);
    EXPECT_EQ(count.fitting, expected.fitting);
    EXPECT_EQ(count.complete, expected.complete);
  }
}

TEST(SequenceCount, OfDesignsAgreesWithBuildingEverySequence) {
  const ModuleLibrary library = two_kinds();
  const std::vector<double> weights{1.0, 2.0, 3.0, 5.0, 7.0};
  for (const std::vector<int>& prefix : {std::vector<int>{}, {1}, {0, 1}, {1, 4}}) {
    for (int n = static_cast<int>(prefix.size()); n <= 5; ++n) {
      SequenceCount expected;
      std::vector<int> types = prefix;
      for_each_sequence(library, n, types, [&](const std::vector<int>& sequence) {
        double designs = 1.0;
        for (const int k : sequence) designs *= weights[static_cast<std::size_t>(k)];
        expected.all += designs;
        if (!library.fits_together(sequence)) return;
        expected.fitting += designs;
        if (library.complete(sequence)) expected.complete += designs;
      });
      const SequenceCount count = count_designs(library, prefix, n, weights);
      EXPECT_EQ(count.all, expected.all) << n;
      EXPECT_EQ(count.fitting, expected.fitting) << n;
      EXPECT_EQ(count.complete, expected.complete) << n;
    }
  }
}

// Three types of which each fits each: 3^n.
TEST(SequenceCount, OfTheReferenceLibraryIsAPowerOfThree) {
  for (int n = 0; n <= 9; ++n) EXPECT_EQ(count_sequences(*load_library("seed"), n).complete, std::pow(3.0, n));
}

/// The connectors and joints of a recorded library; shapes need their meshes and play no part here.
std::shared_ptr<const ModuleLibrary> without_geometry(const std::filesystem::path& file) {
  std::ifstream stream{file};
  nlohmann::json json = nlohmann::json::parse(stream);
  for (nlohmann::json& module : json["modules"]) {
    for (nlohmann::json& body : module["bodies"]) {
      body["collision"] = nlohmann::json::array();
      body.erase("visual");
    }
  }
  const test::TemporaryFolder folder;
  const std::filesystem::path copy = folder.path() / "modules.json";
  write_file(copy, json.dump());
  return load_library(copy.string());
}

// Three of the four joint modules in a row; zero to three of the seven links between neighbours, 1 + 7 + 49 + 343 = 400
// ways; at most one of the seven, 8 ways, before one of the four end effectors: 4^3 * 400^2 * (8 * 4). In this library
// every outlet fits every inlet, so connectors exclude none of them.
TEST(SequenceCount, OfSixAxisArmsOfTheImprovLibraryIsItsClosedForm) {
  const std::filesystem::path file = test::shared_folder() / "data/timor/IMPROV/modules.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  const auto library = without_geometry(file);
  using enum ModuleRole;
  const SequenceCount count = count_sequences(
      *library, {{kJoint}, {kLink, 0, 3}, {kJoint}, {kLink, 0, 3}, {kJoint}, {kLink, 0, 1}, {kEndEffector}});
  EXPECT_EQ(count.all, 327'680'000.0);
  EXPECT_EQ(count.fitting, 327'680'000.0);
  EXPECT_EQ(count.complete, 327'680'000.0);
  // Any sequence: nothing follows one of the four end effectors, eleven types may follow any other.
  for (int n = 1; n <= 10; ++n) {
    EXPECT_EQ(count_sequences(*library, n).fitting, std::pow(11.0, n - 1) * 15.0);
    EXPECT_EQ(count_sequences(*library, n).complete, std::pow(11.0, n - 1) * 4.0);
    EXPECT_EQ(count_sequences(*library, n).all, std::pow(15.0, n));
  }
}

TEST(SequenceCount, RefusesAPartThatIsNoInterval) {
  const ModuleLibrary library = two_kinds();
  EXPECT_THROW((void)count_sequences(library, -1), std::invalid_argument);
  try {
    (void)count_sequences(library, {{ModuleRole::kLink, 3, 2}});
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("a part of 3 to 2 modules"));
  }
}

}  // namespace
}  // namespace modsearch
