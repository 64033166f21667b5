#pragma once

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <stdexcept>

namespace modsearch_check {

/// While it lives, the processor rounds every result as told: FE_UPWARD for intervals. Hold one in a function that
/// calls, and does not contain, the arithmetic: a compiler may move operations across the switch within a function, but
/// not into another source file.
class Rounding {
 public:
  explicit Rounding(int direction) : before_{std::fegetround()} {
    const volatile double one = 1.0;
    const volatile double tiny = 0x1p-60;
    const bool set = std::fesetround(direction) == 0;
    const bool upward = one + tiny > 1.0 && tiny - one > -1.0;
    if (!set || upward != (direction == FE_UPWARD))
      throw std::runtime_error("this machine does not round as it is told");
  }
  ~Rounding() { std::fesetround(before_); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;

 private:
  int before_;
};

/// A closed interval that holds the true value of what was computed. All arithmetic below takes
/// Rounding{FE_UPWARD} for granted: the upper end is rounded up, and so is the lower end's negative, which is stored.
class Interval {
 public:
  constexpr Interval() = default;
  constexpr Interval(double value) : minus_lower_{-value}, upper_{value} {}  // NOLINT: a number is an interval
  constexpr Interval(double lower, double upper) : minus_lower_{-lower}, upper_{upper} {}

  [[nodiscard]] constexpr double lower() const { return -minus_lower_; }
  [[nodiscard]] constexpr double upper() const { return upper_; }
  [[nodiscard]] constexpr bool is_exact() const { return -minus_lower_ == upper_; }
  [[nodiscard]] constexpr bool is_zero() const { return minus_lower_ == 0.0 && upper_ == 0.0; }
  [[nodiscard]] double middle() const { return 0.5 * (upper_ - minus_lower_); }
  /// The same two ends: one and the same number only where is_exact().
  [[nodiscard]] constexpr bool same_as(const Interval& b) const {
    return minus_lower_ == b.minus_lower_ && upper_ == b.upper_;
  }

  friend Interval operator-(const Interval& a) { return Interval{Stored{}, a.upper_, a.minus_lower_}; }
  friend Interval operator+(const Interval& a, const Interval& b) {
    return {Stored{}, a.minus_lower_ + b.minus_lower_, a.upper_ + b.upper_};
  }
  friend Interval operator-(const Interval& a, const Interval& b) {
    return {Stored{}, a.minus_lower_ + b.upper_, a.upper_ + b.minus_lower_};
  }
  friend Interval operator*(const Interval& a, const Interval& b) {
    const double a_lower = -a.minus_lower_;
    const double b_lower = -b.minus_lower_;
    const double minus_a_upper = -a.upper_;
    return {
        Stored{},
        std::max(std::max(a.minus_lower_ * b_lower, a.minus_lower_ * b.upper_),
                 std::max(minus_a_upper * b_lower, minus_a_upper * b.upper_)),
        std::max(std::max(a_lower * b_lower, a_lower * b.upper_), std::max(a.upper_ * b_lower, a.upper_ * b.upper_))};
  }
  friend Interval operator/(const Interval& a, const Interval& b) {
    if (!(b.lower() > 0.0 || b.upper_ < 0.0)) throw std::domain_error("division by what may be zero");
    const double a_lower = -a.minus_lower_;
    const double b_lower = -b.minus_lower_;
    const double minus_a_upper = -a.upper_;
    return {
        Stored{},
        std::max(std::max(a.minus_lower_ / b_lower, a.minus_lower_ / b.upper_),
                 std::max(minus_a_upper / b_lower, minus_a_upper / b.upper_)),
        std::max(std::max(a_lower / b_lower, a_lower / b.upper_), std::max(a.upper_ / b_lower, a.upper_ / b.upper_))};
  }
  Interval& operator+=(const Interval& b) { return *this = *this + b; }
  Interval& operator-=(const Interval& b) { return *this = *this - b; }

 private:
  struct Stored {};
  constexpr Interval(Stored, double minus_lower, double upper) : minus_lower_{minus_lower}, upper_{upper} {}

  double minus_lower_ = 0.0;
  double upper_ = 0.0;
};

/// The interval of |x|.
[[nodiscard]] inline Interval abs(const Interval& x) {
  if (x.lower() >= 0.0) return x;
  if (x.upper() <= 0.0) return -x;
  return {0.0, std::max(-x.lower(), x.upper())};
}

[[nodiscard]] inline Interval square(const Interval& x) {
  const Interval a = abs(x);
  return a * a;
}

/// The least interval with both in it.
[[nodiscard]] inline Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lower(), b.lower()), std::max(a.upper(), b.upper())};
}

/// Square root of what is known not to be negative. IEEE 754 rounds it correctly, here upwards: the double below the
/// rounded root lies below the true one.
[[nodiscard]] inline Interval sqrt(const Interval& x) {
  const double root = std::sqrt(std::max(x.lower(), 0.0));
  return {root > 0.0 ? std::nextafter(root, 0.0) : 0.0, std::sqrt(std::max(x.upper(), 0.0))};
}

/// The double above pi.
inline constexpr double kPiUp = 0x1.921fb54442d19p+1;

}  // namespace modsearch_check
