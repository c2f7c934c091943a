#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

/// Functions whose results do not depend on the C library, so that stores and demo volumes are the
/// same bytes natively, in WebAssembly, and on every machine. They use only operations that IEEE
/// 754 defines exactly (+ − × ÷ √ and bit shifts), compiled with -ffp-contract=off. Accurate to
/// about 1e-12.
namespace isosplat::portable {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kLn2 = 0.69314718055994530942;

/// 2^k. Requires −1022 ≤ k ≤ 1023.
inline double power_of_two(int k) {
  const uint64_t bits = static_cast<uint64_t>(k + 1023) << 52;
  double power = 0;
  std::memcpy(&power, &bits, sizeof power);
  return power;
}

/// eˣ for −700 < x < 700: Taylor's series after reduction by powers of two.
inline double exp(double x) {
  const double k = std::floor(x / kLn2 + 0.5);
  const double r = x - k * kLn2;
  constexpr auto kInverseFactorials = [] {
    std::array<double, 15> inverses{1};
    for (size_t i = 1; i < inverses.size(); ++i) {
      inverses[i] = inverses[i - 1] / static_cast<double>(i);
    }
    return inverses;
  }();
  double sum = 0;
  for (size_t i = kInverseFactorials.size(); i-- > 0;) sum = sum * r + kInverseFactorials[i];
  return sum * power_of_two(static_cast<int>(k));
}

/// ln x for normal x > 0: the series of 2 artanh((m − 1)/(m + 1)) for the mantissa m.
inline double log(double x) {
  uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  int k = static_cast<int>(bits >> 52) - 1023;
  bits = (bits & 0xfffffffffffffull) | (uint64_t{1023} << 52);
  double m = 0;
  std::memcpy(&m, &bits, sizeof m);
  if (m > 1.41421356237309504880) {
    m *= 0.5;
    ++k;
  }
  const double s = (m - 1) / (m + 1);
  const double s2 = s * s;
  double power = s, sum = 0;
  for (int i = 1; i <= 27; i += 2) {
    sum += power / i;
    power *= s2;
  }
  return 2 * sum + k * kLn2;
}

/// log₂ x for normal x > 0.
inline double log2(double x) {
  return log(x) / kLn2;
}

/// xʸ for normal x > 0 and |y ln x| < 700; 0 for x = 0.
inline double pow(double x, double y) {
  return x > 0 ? exp(y * log(x)) : 0;
}

/// cos x for |x| < 1e6.
inline double cos(double x) {
  const double turns = std::floor(x / (2 * kPi) + 0.5);
  const double r = x - turns * (2 * kPi);  // −π … π
  const double q = r * 0.25;               // the series converges quickly there
  const double q2 = q * q;
  double term = 1, sum = 1;
  for (int i = 1; i <= 8; ++i) {
    term = -term * q2 / ((2 * i - 1) * (2 * i));
    sum += term;
  }
  const double half = 2 * sum * sum - 1;
  return 2 * half * half - 1;
}

inline double sin(double x) {
  return cos(x - kPi / 2);
}

}  // namespace isosplat::portable
