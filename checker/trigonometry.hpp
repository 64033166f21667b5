#pragma once

#include <checker/interval.hpp>

namespace modsearch_check {

struct SinCos {
  Interval sin;
  Interval cos;
};

/// Sum of (-t)^k / (2 k + first)! over k = 0 .. 8, for t in [0, 1]: a series that alternates and falls, so what is left
/// out is smaller than its first term.
[[nodiscard]] inline Interval alternating_series(int first, const Interval& t) {
  static const auto inverse_factorial = [] {
    std::array<Interval, 20> table;
    double factorial = 1.0;  // a double holds n! exactly up to 19! and beyond
    for (std::size_t n = 0; n < table.size(); ++n) {
      if (n > 0) factorial *= static_cast<double>(n);
      table[n] = Interval{1.0} / factorial;
    }
    return table;
  }();
  const double left_out = inverse_factorial[static_cast<std::size_t>(18 + first)].upper();  // times t^9, at most 1
  Interval sum{-left_out, left_out};
  for (int n = 16 + first; n >= first; n -= 2) sum = inverse_factorial[static_cast<std::size_t>(n)] - t * sum;
  return sum;
}

/// Enclosures of the sine and the cosine of a double of at most a million.
///
/// x = k pi/2 + r with |r| < 0.8, then Taylor's series in r. pi/2 = 1.921FB544 42D18469 898CC517 01B839A2..
/// (hexadecimal) comes in three pieces, so that k times the first two is exact.
[[nodiscard]] inline SinCos sin_cos(double x) {
  if (!(std::abs(x) <= 1e6)) throw std::domain_error("an angle is larger than a million");
  const Interval third{0x1.13198a2e03707p-65, 0x1.13198a2e03708p-65};
  const double k = std::floor(x * 0x1.45f306dc9c883p-1 + 0.5);  // 2/pi; any k near it would do
  const Interval r = ((Interval{x} - Interval{k} * 0x1.921fb544p+0) - Interval{k} * 0x1.0b4611a4p-34) - third * k;
  const Interval t = square(r);
  if (!(t.upper() < 1.0)) throw std::domain_error("an angle was reduced wrongly");
  const Interval sine = r * alternating_series(1, t);
  const Interval cosine = alternating_series(0, t);
  switch (static_cast<long>(k) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace modsearch_check
