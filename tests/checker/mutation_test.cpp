#include <gmock/gmock.h>

#include <cfenv>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/problem/files.hpp>
#include <random>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

/// A problem among obstacles, its certificate, and how low a bound can be before it is false.
struct Case {
  Json certificate;
  double best;  // score of a design that is achieved
};

Case fixed_target() {
  const Rounding up{FE_UPWARD};
  Json made = naive_certificate("seed/fixed", read_problem("seed/fixed", "", 0, 0), 341.93, 1);
  add_incumbent_of_seed_fixed(made);
  return {made, made["claim"]["lower"].get<double>()};
}

/// What the search writes: halved circles, parts cut off, obstacle rows.
Case written_by_the_search(const std::string& id, std::uint64_t index, double gap) {
  const modsearch::Instance instance{7, index};
  const auto problem = modsearch::load_problem(id, instance);
  modsearch::Meter meter;
  const modsearch::Certificate made =
      modsearch::make_certificate(*problem, {.gap = gap}, {id, instance, R"({"type":"algorithm1"})"}, meter);
  return {Json::parse(made.json), made.lower.value()};
}

std::vector<Case> all_cases() {
  std::vector<Case> cases{fixed_target(), written_by_the_search("seed/random_obstacles", 1, 1e-3),
                          written_by_the_search("breakeven/two_goals", 1, 0.02)};
  for (std::size_t i = 1; i < cases.size(); ++i) {
    const std::string text = cases[i].certificate.dump();
    EXPECT_THAT(text, testing::HasSubstr("[\"h\","));
    EXPECT_THAT(text, testing::HasSubstr("[\"c\","));
  }
  return cases;
}

enum class Verdict { kAccepted, kRejected, kMalformed };

Verdict verdict(const std::string& text) {
  const TemporaryFile file{"mutated.json"};
  file.write(text);
  try {
    static_cast<void>(check_certificate(file.path()));
    return Verdict::kAccepted;
  } catch (const Rejected&) {
    return Verdict::kRejected;
  } catch (const Malformed&) {
    return Verdict::kMalformed;
  }
}

class Mutations {
 public:
  explicit Mutations(std::uint64_t seed) : bits_{seed} {}

  /// Makes the claim false (or leaves a gap in its proof that nothing else can fill), in one of nine ways.
  std::string false_claim(const Case& from) {
    Json c = from.certificate;
    const double size = std::exp2(-uniform(0.0, 20.0));
    Json& sequence = c["sequences"][index(c["sequences"].size())];
    switch (index(9)) {
      case 0:  // a bound below the score of a design that is achieved, with a gap to match or not
        c["claim"]["upper"] = from.best - size;
        if (index(2) == 0) c["claim"]["gap"] = -size / mass_term(c);
        if (index(2) == 0) {
          c.erase("incumbent");
          c["claim"].erase("lower");
          c["claim"].erase("gap");
        }
        break;
      case 1:
        move(c["statement"]["goals"][0]["position"][index(3)], size);
        break;
      case 2: {
        const char* names[][2] = {{"link", "length"}, {"hinge", "proximal"}, {"hinge", "distal"}, {"rotary", "distal"}};
        const auto& name = names[index(4)];
        move(c["statement"]["library"][name[0]][name[1]][index(2)], size);
        break;
      }
      case 3: {  // a split or a leaf: without parts that are cut off, or with a whole circle, it may still be a proof
        Json& tree = sequence["tree"];
        std::size_t node = index(tree.size());
        while (tree[node][0] == "c" || tree[node][0] == "h") node = (node + 1) % tree.size();
        tree.erase(node);
        break;
      }
      case 4:
        c["sequences"].erase(index(c["sequences"].size()));
        break;
      case 5: {  // no variable gets there
        const std::string nowhere = hex(index(2) == 0 ? 4.0 + size : -4.0 - size);
        std::vector<Json*> places;
        for (Json& one : c["sequences"]) {
          for (Json& node : one["tree"]) {
            if (node[0] == "s") places.push_back(&node[2]);
            if (node[0] != "c") continue;
            for (std::size_t group = 1; group < node.size(); ++group) {
              for (std::size_t part = 1; part < node[group].size(); ++part) places.push_back(&node[group][part][1]);
            }
          }
        }
        *places[index(places.size())] = nowhere;
        break;
      }
      case 6:
        if (index(2) == 0) {  // further than the tolerance, towards the outside
          move(c["incumbent"]["design"].back()["parameters"]["distal"], 0.0021 + size);
        } else {
          move(c["incumbent"]["postures"][0][index(2)], 0.01 + size);
        }
        break;
      case 7: {  // half of a length, or half a circle in the middle of a tree
        Json& tree = sequence["tree"];
        const bool length = index(2) == 0;
        const auto behind =
            std::find_if(tree.begin(), tree.end(), [](const Json& n) { return n[0] != "h"; }) - tree.begin();
        tree.insert(tree.begin() + (length ? 0 : behind + 1), Json({"h", length ? 0 : 2}));
        break;
      }
      default:
        c["claim"]["gap"] = c["claim"]["gap"].get<double>() * (1.0 - size) - 2e-9;
    }
    return c.dump();
  }

  /// Changes anything at all.
  std::string arbitrary(const Case& from) {
    if (index(3) == 0) {
      std::string text = from.certificate.dump();
      for (std::size_t n = 1 + index(3); n > 0; --n) {
        const std::size_t at = index(text.size());
        switch (index(4)) {
          case 0:
            text[at] = static_cast<char>(text[at] ^ (1 << index(8)));
            break;
          case 1:
            text.erase(at, 1 + index(20));
            break;
          case 2:
            text.insert(at, text, index(text.size()), 1 + index(20));
            break;
          default:
            text.resize(at);
        }
        if (text.empty()) break;
      }
      return text;
    }
    Json c = from.certificate;
    Json* value = &c;
    while (value->is_structured() && !value->empty() && (index(12) != 0 || value == &c)) {
      auto child = value->begin();
      std::advance(child, static_cast<std::ptrdiff_t>(index(value->size())));
      value = &*child;
    }
    switch (index(7)) {
      case 0:
        *value = nullptr;
        break;
      case 1:
        *value = hex(uniform(-4.0, 4.0));
        break;
      case 2:
        *value = std::exp2(uniform(-60.0, 60.0));
        break;
      case 3:
        *value = Json::array({*value, *value});
        break;
      case 4:
        *value = index(40);
        break;
      case 5:
        if (value->is_structured() && !value->empty()) value->erase(value->begin());
        break;
      default:
        if (value->is_string()) move(*value, std::exp2(-uniform(0.0, 50.0)));
    }
    return c.dump();
  }

 private:
  double uniform(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  std::size_t index(std::size_t n) { return bits_() % n; }
  static double mass_term(const Json& certificate) {
    const Json& claim = certificate["claim"];
    return (claim["upper"].get<double>() - claim["lower"].get<double>()) / claim["gap"].get<double>();
  }
  void move(Json& number, double size) {
    const std::string text = number.get<std::string>();
    number = hex(std::strtod(text.c_str(), nullptr) + (index(2) == 0 ? size : -size));
  }

  std::mt19937_64 bits_;
};

std::size_t accepted_false_claims(std::size_t n) {
  const std::vector<Case> cases = all_cases();
  for (const Case& from : cases) EXPECT_EQ(verdict(from.certificate.dump()), Verdict::kAccepted);
  Mutations mutations{11};
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string text = mutations.false_claim(cases[i % cases.size()]);
    if (verdict(text) == Verdict::kRejected) continue;
    ++accepted;
    ADD_FAILURE() << "not rejected: " << text.substr(0, 2000);
  }
  return accepted;
}

/// Whatever is changed, a verdict is given, and what is accepted does not claim a bound below what a design scores.
void change_anything(std::size_t n) {
  const std::vector<Case> cases = all_cases();
  Mutations mutations{12};
  for (std::size_t i = 0; i < n; ++i) {
    const Case& from = cases[i % cases.size()];
    const std::string text = mutations.arbitrary(from);
    if (verdict(text) != Verdict::kAccepted) continue;
    const Json claim = Json::parse(text)["claim"];
    EXPECT_FALSE(claim.contains("unreachable"));
    EXPECT_GE(claim["upper"].get<double>(), from.best - 1e-9);
  }
}

TEST(Mutations, ThatMakeAClaimFalseAreRejected) { EXPECT_EQ(accepted_false_claims(500), 0U); }
TEST(SlowMutations, ThatMakeAClaimFalseAreRejectedWithoutException) { EXPECT_EQ(accepted_false_claims(10'000), 0U); }
TEST(Mutations, OfAnyKindGetAVerdict) { change_anything(500); }
TEST(SlowMutations, OfAnyKindGetAVerdictWithoutException) { change_anything(10'000); }

}  // namespace
}  // namespace modsearch_check
