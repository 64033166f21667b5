#include <gmock/gmock.h>

#include <cfenv>
#include <checker/json.hpp>
#include <checker/trigonometry.hpp>
#include <cmath>
#include <random>

namespace modsearch_check {
namespace {

/// The processor rounds up while a test runs.
class Intervals : public testing::Test {
 protected:
  /// A double of either sign whose size is anything from 2^-30 to 2^30.
  double draw() {
    const double size =
        std::ldexp(1.0 + static_cast<double>(bits_() >> 12) * 0x1p-52, static_cast<int>(bits_() % 61) - 30);
    return bits_() % 2 == 0 ? size : -size;
  }

  std::mt19937_64 bits_{1};

 private:
  Rounding up_{FE_UPWARD};
};

// A product of two doubles has 106 bits and a sum of near ones fewer than 113, so that __float128 holds them exactly.
__extension__ using Exact = __float128;

void expect_holds(const Interval& interval, Exact value) {
  EXPECT_LE(static_cast<Exact>(interval.lower()), value);
  EXPECT_GE(static_cast<Exact>(interval.upper()), value);
  EXPECT_LE(interval.upper(), std::nextafter(interval.lower(), INFINITY)) << "wider than one step";
}

TEST_F(Intervals, HoldTheExactSumDifferenceAndProductBetweenNeighbouringDoubles) {
  for (int i = 0; i < 100'000; ++i) {
    const double a = draw();
    const double b = draw();
    expect_holds(Interval{a} * b, static_cast<Exact>(a) * b);
    const double near = a * (1.0 + static_cast<double>(i % 7));
    expect_holds(Interval{a} + near, static_cast<Exact>(a) + near);
    expect_holds(Interval{a} - near, static_cast<Exact>(a) - near);
  }
}

TEST_F(Intervals, HoldTheQuotientWhoseProductWithTheDivisorIsTheDividend) {
  for (int i = 0; i < 100'000; ++i) {
    const double a = draw();
    const double b = std::abs(draw());
    const Interval quotient = Interval{a} / b;
    EXPECT_LE(static_cast<Exact>(quotient.lower()) * b, static_cast<Exact>(a));
    EXPECT_GE(static_cast<Exact>(quotient.upper()) * b, static_cast<Exact>(a));
  }
  EXPECT_THROW(static_cast<void>(Interval{1.0} / (Interval{-1.0, 1.0})), std::domain_error);
}

TEST_F(Intervals, HoldTheRootBetweenDoublesWhoseSquaresLieOnEitherSide) {
  for (int i = 0; i < 100'000; ++i) {
    const double a = std::abs(draw());
    const Interval root = sqrt(Interval{a});
    EXPECT_LE(static_cast<Exact>(root.lower()) * root.lower(), static_cast<Exact>(a));
    EXPECT_GE(static_cast<Exact>(root.upper()) * root.upper(), static_cast<Exact>(a));
  }
  EXPECT_EQ(sqrt(Interval{0.0}).upper(), 0.0);
}

TEST_F(Intervals, ContainWhatTheirMembersGive) {
  const auto between = [&](const Interval& x) {
    return x.lower() + (x.upper() - x.lower()) * static_cast<double>(bits_() % 1025) / 1024.0;
  };
  for (int i = 0; i < 100'000; ++i) {
    const double a = std::remainder(draw(), 8.0);
    const double b = std::remainder(draw(), 8.0);
    const Interval x{std::min(a, b), std::max(a, b)};
    const Interval y{-std::max(a, b), -std::min(a, b) + 1.0};
    const double p = std::min(between(x), x.upper());
    const double q = std::min(between(y), y.upper());
    const auto holds = [](const Interval& interval, Exact value) {
      return static_cast<Exact>(interval.lower()) <= value && value <= static_cast<Exact>(interval.upper());
    };
    EXPECT_TRUE(holds(x + y, static_cast<Exact>(p) + q));
    EXPECT_TRUE(holds(x - y, static_cast<Exact>(p) - q));
    EXPECT_TRUE(holds(x * y, static_cast<Exact>(p) * q));
    EXPECT_TRUE(holds(square(x), static_cast<Exact>(p) * p));
    EXPECT_TRUE(holds(abs(x), static_cast<Exact>(std::abs(p))));
    EXPECT_TRUE(holds(-x, -static_cast<Exact>(p)));
  }
}

/// Sine and cosine in the 64 bits of long double, in the rounding they are made for: off by a unit or two of 2^-64.
std::pair<long double, long double> reference(double x) {
  const Rounding nearest{FE_TONEAREST};
  return {std::sin(static_cast<long double>(x)), std::cos(static_cast<long double>(x))};
}

void expect_encloses(double x) {
  const SinCos mine = sin_cos(x);
  const auto [sine, cosine] = reference(x);
  constexpr long double kOff = 0x1p-62L;
  EXPECT_LE(static_cast<long double>(mine.sin.lower()), sine + kOff) << x;
  EXPECT_GE(static_cast<long double>(mine.sin.upper()), sine - kOff) << x;
  EXPECT_LE(static_cast<long double>(mine.cos.lower()), cosine + kOff) << x;
  EXPECT_GE(static_cast<long double>(mine.cos.upper()), cosine - kOff) << x;
  EXPECT_LE(mine.sin.upper() - mine.sin.lower(), 1e-15) << x;  // r^2 and the series round a few times
  EXPECT_LE(mine.cos.upper() - mine.cos.lower(), 1e-15) << x;
}

TEST_F(Intervals, EncloseSineAndCosine) {
  for (int i = 0; i < 200'000; ++i) expect_encloses(std::remainder(draw(), 1000.0));
}

TEST_F(Intervals, EncloseSineAndCosineAroundMultiplesOfAnEighthOfATurn) {
  for (int k = -40; k <= 40; ++k) {
    for (const double off : {0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8, 1e-4, -1e-4})
      expect_encloses(k * 0.7853981633974483 + off);
  }
  for (const double x : {0.0, 0x1p-1074, -0x1p-1022, 1e-300, 1e5, -1e6, 0.8, -0.8}) expect_encloses(x);
}

TEST_F(Intervals, KnowTheSineOfSpecialAngles) {
  EXPECT_EQ(sin_cos(0.0).sin.upper(), 0.0);
  EXPECT_LE(sin_cos(0.0).cos.lower(), 1.0);
  EXPECT_GE(sin_cos(0.0).cos.upper(), 1.0);
  // The double below pi is short of pi by 1.2246467991473532e-16 (Kahan's example): its sine is that.
  const Interval at_pi = sin_cos(0x1.921fb54442d18p+1).sin;
  EXPECT_LE(at_pi.lower(), 1.2246467991473532e-16);
  EXPECT_GE(at_pi.upper(), 1.2246467991473531e-16);
  EXPECT_LE(sin_cos(kPiUp).sin.upper(), 0.0) << "the double above pi lies beyond it";
  EXPECT_THROW(static_cast<void>(sin_cos(1.1e6)), std::domain_error);
  EXPECT_THROW(static_cast<void>(sin_cos(NAN)), std::domain_error);
}

TEST_F(Intervals, EncloseTheRotationNearestToAMatrix) {
  // R = Q S with S symmetric and near 1 has Q as its polar factor; S is known here, so Q is known as R S^-1.
  const SinCos turn = sin_cos(0.7);
  const double c = turn.cos.middle();
  const double s = turn.sin.middle();
  const double e = 4e-7;
  const std::array<Numbers, 3> given = {Numbers{c * (1.0 + e), -s, 0.0}, {s * (1.0 + e), c, 0.0}, {0.0, 0.0, 1.0 - e}};
  const Json json;
  const Matrix R = nearest_rotation(given, {json, "here"});
  EXPECT_NEAR(R[0][0].middle(), c, 1e-15);
  EXPECT_NEAR(R[1][0].middle(), s, 1e-15);
  EXPECT_NEAR(R[0][1].middle(), -s, 1e-15);
  EXPECT_NEAR(R[2][2].middle(), 1.0, 1e-15);
  EXPECT_LE(R[0][0].lower(), turn.cos.upper());
  EXPECT_GE(R[0][0].upper(), turn.cos.lower());
  EXPECT_THROW(
      static_cast<void>(nearest_rotation({Numbers{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}}, {json, ""})),
      Malformed);
}

}  // namespace
}  // namespace modsearch_check
