#include <gmock/gmock.h>

#include <cfenv>
#include <fstream>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

/// What the checker says of a certificate: "accepted", or the reason of its refusal.
std::string verdict(const Json& certificate) {
  const TemporaryFile file{"certificate.json"};
  file.write(certificate.dump());
  try {
    static_cast<void>(check_certificate(file.path()));
    return "accepted";
  } catch (const Rejected& reason) {
    return std::string{"rejected: "} + reason.what();
  } catch (const Malformed& reason) {
    return std::string{"malformed: "} + reason.what();
  }
}

/// seed/fixed to 0.1 % of the mass.
const Json& certificate_of_seed_fixed() {
  static const Json certificate = [] {
    const Rounding up{FE_UPWARD};
    Json made = naive_certificate("seed/fixed", read_problem("seed/fixed", "", 0, 0), 341.923, 1);
    add_incumbent_of_seed_fixed(made);
    return made;
  }();
  return certificate;
}

TEST(Certificate, OfTheFixedTargetIsAccepted) { EXPECT_EQ(verdict(certificate_of_seed_fixed()), "accepted"); }

TEST(Certificate, IsPutIntoWords) {
  const TemporaryFile file{"words.json"};
  file.write(certificate_of_seed_fixed().dump());
  const std::string words = in_words(check_certificate(file.path()));
  EXPECT_THAT(words,
              testing::HasSubstr("seed/fixed: no design with at most 10 modules (the base counted) that reaches every "
                                 "goal without touching an obstacle there scores above 341.923"));
  EXPECT_THAT(words, testing::HasSubstr("No part of the proof: torques"));
}

/// A change of the certificate of seed/fixed that makes it claim what is false, or prove less than it claims.
struct FalseClaim {
  std::string name;
  std::string reason;  // part of it
  std::function<void(Json&)> change;
};

class FalseClaims : public testing::TestWithParam<FalseClaim> {};

TEST_P(FalseClaims, AreRejected) {
  Json certificate = certificate_of_seed_fixed();
  GetParam().change(certificate);
  EXPECT_THAT(verdict(certificate), testing::StartsWith("rejected: ")) << GetParam().name;
  EXPECT_THAT(verdict(certificate), testing::HasSubstr(GetParam().reason));
}

double claimed(const Json& certificate, const char* key) { return certificate["claim"][key].get<double>(); }

INSTANTIATE_TEST_SUITE_P(
    Certificate, FalseClaims,
    testing::Values(
        FalseClaim{"bound below the incumbent's score", "scores more than the claimed bound",
                   [](Json& c) { c["claim"]["upper"] = claimed(c, "lower") - 1e-6; }},
        FalseClaim{"bound lower than was proved", "the gap is",
                   [](Json& c) { c["claim"]["upper"] = 0.5 * (claimed(c, "upper") + claimed(c, "lower")); }},
        FalseClaim{"bound lower than was proved, gap to match", "too little",
                   [](Json& c) {
                     const double upper = claimed(c, "lower") + 1e-5;
                     c["claim"]["gap"] = claimed(c, "gap") * 1e-5 / (claimed(c, "upper") - claimed(c, "lower"));
                     c["claim"]["upper"] = upper;
                   }},
        FalseClaim{"score overstated", "not what is claimed",
                   [](Json& c) { c["claim"]["lower"] = claimed(c, "lower") + 1e-6; }},
        FalseClaim{"gap understated", "the gap is", [](Json& c) { c["claim"]["gap"] = 0.5 * claimed(c, "gap"); }},
        FalseClaim{"target moved", "goal 1", [](Json& c) { c["statement"]["goals"][0]["position"][0] = hex(0.9); }},
        FalseClaim{"tolerance changed", "tolerance of goal 1",
                   [](Json& c) { c["statement"]["goals"][0]["radius"] = hex(0.0005); }},
        FalseClaim{"length bounds changed", "interval of hinge.proximal",
                   [](Json& c) { c["statement"]["library"]["hinge"]["proximal"][0] = hex(0.6); }},
        FalseClaim{"a module type left out", "list of module types",
                   [](Json& c) { c["statement"]["library"].erase("rotary"); }},
        FalseClaim{"another number of modules", "number of modules", [](Json& c) { c["statement"]["maxModules"] = 2; }},
        FalseClaim{"another scoring", "scoring",
                   [](Json& c) {
                     c["statement"]["scoring"] = {{"type", "weighted"}};
                   }},
        FalseClaim{"another level", "collision level", [](Json& c) { c["statement"]["collision"] = "none"; }},
        FalseClaim{"obstacles left out", "obstacle shapes", [](Json& c) { c["statement"]["obstacles"] = 1; }},
        FalseClaim{"another problem", "", [](Json& c) { c["problem"] = "seed/random_wide"; }},
        FalseClaim{"sequence dropped", "a sequence is missing: hinge", [](Json& c) { c["sequences"].erase(1); }},
        FalseClaim{"sequences out of order", "missing",
                   [](Json& c) { std::swap(c["sequences"][0], c["sequences"][2]); }},
        FalseClaim{"sequence that is not needed", "not needed",
                   [](Json& c) { c["sequences"].push_back(c["sequences"][0]); }},
        FalseClaim{"leaf dropped", "",
                   [](Json& c) { c["sequences"][1]["tree"].erase(c["sequences"][1]["tree"].size() - 1); }},
        FalseClaim{"nodes left over", "left over",
                   [](Json& c) { c["sequences"][1]["tree"].push_back(c["sequences"][1]["tree"].back()); }},
        FalseClaim{"no tree", "ends before", [](Json& c) { c["sequences"][1]["tree"] = Json::array(); }},
        FalseClaim{"split moved outward", "outside its box",
                   [](Json& c) { c["sequences"][1]["tree"][0][2] = hex(9.0); }},
        FalseClaim{"incumbent lengthened", "does not reach",
                   [](Json& c) { c["incumbent"]["design"][0]["parameters"]["distal"] = hex(1.13); }},
        FalseClaim{"incumbent out of bounds", "outside its interval",
                   [](Json& c) { c["incumbent"]["design"][0]["parameters"]["proximal"] = hex(0.49); }},
        FalseClaim{"incumbent bent", "does not reach", [](Json& c) { c["incumbent"]["postures"][0][1] = hex(1.0); }},
        FalseClaim{"incumbent of another type", "", [](Json& c) { c["incumbent"]["design"][0]["type"] = "rotary"; }},
        FalseClaim{"incumbent beyond its joint limits", "beyond its limits",
                   [](Json& c) { c["incumbent"]["postures"][0][0] = hex(std::acos(0.0) - 2.0 * kPiUp); }},
        FalseClaim{"unreachable, though it is not", "a design is given",
                   [](Json& c) {
                     c["claim"] = {{"unreachable", true}};
                   }},
        FalseClaim{"unreachable, though it is not, no incumbent", "",
                   [](Json& c) {
                     c["claim"] = {{"unreachable", true}};
                     c.erase("incumbent");
                   }},
        FalseClaim{"a score without a design", "no design is given", [](Json& c) { c.erase("incumbent"); }}),
    [](const auto& tested) {
      std::string name = tested.param.name;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
      return name;
    });

/// What cannot be read: where, and what it is.
struct Unreadable {
  std::string complaint;
  std::string text;
};

TEST(Certificate, ThatCannotBeReadIsRefusedInOneSentence) {
  const std::string good = certificate_of_seed_fixed().dump();
  const auto changed = [](const std::function<void(Json&)>& change) {
    Json json = certificate_of_seed_fixed();
    change(json);
    return json.dump();
  };
  const std::vector<Unreadable> cases = {
      {"is empty", ""},
      {"is not JSON", good.substr(0, good.size() / 2)},
      {"is not JSON", good + "x"},
      {"is not JSON", "{\"modsearch\": NaN}"},
      {"is not JSON", "{\"modsearch\": 1e999}"},
      {"nested deeper than 64", std::string(100'000, '[')},
      {"occurs twice", "{\"modsearch\": 1, \"modsearch\": 1}"},
      {"is not an object", "[]"},
      {"is missing", "{}"},
      {"is not known here", changed([](Json& c) { c["extra"] = 1; })},
      {"is not known here", changed([](Json& c) { c["claim"]["extra"] = 1; })},
      {"is not known here", changed([](Json& c) { c["sequences"][0]["extra"] = 1; })},
      {"is not a number", changed([](Json& c) { c["claim"]["upper"] = "0x1p+0"; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = 1.0; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = "nan"; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = "0xinf"; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = "0x1p+0 "; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = "0x1p+9999"; })},
      {"hexadecimal float", changed([](Json& c) { c["sequences"][0]["tree"][0][1] = "1.0"; })},
      {"not one of the words", changed([](Json& c) { c["sequences"][0]["tree"][0][0] = "x"; })},
      {"is not an integer in [0, 3]", changed([](Json& c) { c["sequences"][1]["tree"][0][1] = 4; })},
      {"is not an integer in [0, 3]", changed([](Json& c) { c["sequences"][1]["tree"][0][1] = -1; })},
      {"a list of 3", changed([](Json& c) { c["sequences"][1]["tree"][0].push_back(0); })},
      {"begins with its kind", changed([](Json& c) { c["sequences"][0]["tree"][0] = Json::array(); })},
      {"three multipliers per goal", changed([](Json& c) {
         c["sequences"][0]["tree"][0] = {"m", "0x0p+0"};
       })},
      {"no such file", changed([](Json& c) { c["problem"] = "seed/nowhere"; })},
      {"a list of 2", changed([](Json& c) { c["incumbent"]["postures"][0].push_back("0x0p+0"); })},
      {"a list of 1", changed([](Json& c) { c["incumbent"]["postures"] = Json::array(); })},
  };
  for (const auto& [complaint, text] : cases) {
    const TemporaryFile file{"unreadable.json"};
    file.write(text);
    try {
      static_cast<void>(check_certificate(file.path()));
      ADD_FAILURE() << "accepted in place of: " << complaint;
    } catch (const Malformed& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(complaint));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
    } catch (const Rejected& error) {
      ADD_FAILURE() << "rejected (" << error.what() << ") in place of: " << complaint;
    }
  }
}

}  // namespace
}  // namespace modsearch_check
