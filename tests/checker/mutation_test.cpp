#include <gmock/gmock.h>

#include <cfenv>
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

  /// Makes the claim false (or leaves a gap in its proof that nothing else can fill), in one of eight ways.
  std::string false_claim(const Case& from) {
    Json c = from.certificate;
    const double size = std::exp2(-uniform(0.0, 20.0));
    Json& sequence = c["sequences"][index(3)];
    switch (index(8)) {
      case 0:  // a bound below the score of a design that is achieved, with a gap to match or not
        c["claim"]["upper"] = from.best - size;
        if (index(2) == 0) c["claim"]["gap"] = -size / (350.0 - from.best) * 1.0;
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
      case 3:
        sequence["tree"].erase(index(sequence["tree"].size()));
        break;
      case 4:
        c["sequences"].erase(index(3));
        break;
      case 5: {
        Json& tree = c["sequences"][1]["tree"];
        std::size_t node = index(tree.size());
        while (tree[node][0] != "s") node = (node + 1) % tree.size();
        tree[node][2] = hex(index(2) == 0 ? 4.0 + size : -4.0 - size);  // no variable gets there
        break;
      }
      case 6:
        if (index(2) == 0) {  // further than the tolerance, towards the outside
          move(c["incumbent"]["design"][0]["parameters"]["distal"], 0.0021 + size);
        } else {
          move(c["incumbent"]["postures"][0][index(2)], 0.01 + size);
        }
        break;
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
  void move(Json& number, double size) {
    const std::string text = number.get<std::string>();
    number = hex(std::strtod(text.c_str(), nullptr) + (index(2) == 0 ? size : -size));
  }

  std::mt19937_64 bits_;
};

std::size_t accepted_false_claims(std::size_t n) {
  const Case from = fixed_target();
  EXPECT_EQ(verdict(from.certificate.dump()), Verdict::kAccepted);
  Mutations mutations{11};
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string text = mutations.false_claim(from);
    if (verdict(text) == Verdict::kRejected) continue;
    ++accepted;
    ADD_FAILURE() << "not rejected: " << text.substr(0, 2000);
  }
  return accepted;
}

/// Whatever is changed, a verdict is given, and what is accepted does not claim a bound below what a design scores.
void change_anything(std::size_t n) {
  const Case from = fixed_target();
  Mutations mutations{12};
  for (std::size_t i = 0; i < n; ++i) {
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
