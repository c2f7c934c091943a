#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

/// Functions whose results do not depend on the C library, so that the demo volumes are the same
/// bytes on every machine. They use only operations that IEEE 754 defines exactly (+ − × ÷ √ and
/// bit shifts), compiled with -ffp-contract=off. Accurate to about 1e-12, far below the resolution
/// of 8 bits.
namespace isosplat::portable {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kLn2 = 0.69314718055994530942;

/// 2^k. Requires −1022 ≤ k ≤ 1023.
inline double power_of_two(int k) {
  return std::bit_cast<double>(static_cast<uint64_t>(k + 1023) << 52);
}

/// eˣ for −700 < x < 700: Taylor's series after reduction by powers of two.
inline double exp(double x) {
  const double k = std::floor(x / kLn2 + 0.5);
  const double r = x - k * kLn2;
  double term = 1, sum = 1;
  for (int i = 1; i <= 14; ++i) {
    term = term * r / i;
    sum += term;
  }
  return sum * power_of_two(static_cast<int>(k));
}

/// ln x for normal x > 0: the series of 2 artanh((m − 1)/(m + 1)) for the mantissa m.
inline double log(double x) {
  const auto bits = std::bit_cast<uint64_t>(x);
  int k = static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xfffffffffffffull) | (uint64_t{1023} << 52));
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

/// cos x for |x| < 1e6.
inline double cos(double x) {
  const double turns = std::floor(x / (2 * kPi) + 0.5);
  const double r = x - turns * (2 * kPi);  // −π … π
  const double q = r * 0.25;               // a quarter of it, where the series is short
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
