#include "tests/evidence/ewa/spectrum.h"

#include <cmath>
#include <numbers>
#include <numeric>

namespace isosplat {

void fourier(std::span<std::complex<double>> values) {
  const size_t n = values.size();
  for (size_t i = 1, j = 0; i < n; ++i) {
    size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (size_t size = 2; size <= n; size *= 2) {
    for (size_t k = 0; k < size / 2; ++k) {
      const auto turn = std::polar(1.0, -2 * std::numbers::pi * double(k) / double(size));
      for (size_t i = k; i < n; i += size) {
        const auto odd = turn * values[i + size / 2];
        values[i + size / 2] = values[i] - odd;
        values[i] += odd;
      }
    }
  }
}

Spectrum::Spectrum(const Luminance& fine, int per_px) : side_(fine.width), per_px_(per_px) {
  const auto n = static_cast<size_t>(side_);
  const double mean =
      std::accumulate(fine.value.begin(), fine.value.end(), 0.0) / double(fine.value.size());
  const auto window = [&](size_t i) {
    return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (double(i) + 0.5) / double(n));
  };
  wave_.resize(n * n);
  for (size_t i = 0; i < n * n; ++i) {
    wave_[i] = (fine.value[i] - mean) * window(i % n) * window(i / n);
  }
  for (size_t row = 0; row < n; ++row) fourier(std::span(wave_).subspan(row * n, n));
  std::vector<std::complex<double>> column(n);
  for (size_t x = 0; x < n; ++x) {
    for (size_t y = 0; y < n; ++y) column[y] = wave_[y * n + x];
    fourier(column);
    for (size_t y = 0; y < n; ++y) wave_[y * n + x] = column[y];
  }
}

double Spectrum::frequency(int i) const {
  return double(i < side_ / 2 ? i : i - side_) * per_px_ / side_;
}

template <class F>
void Spectrum::for_waves(F f) const {
  for (int y = 0; y < side_; ++y) {
    for (int x = 0; x < side_; ++x) {
      if (x == 0 && y == 0) continue;
      f(size_t(y) * size_t(side_) + size_t(x), frequency(x), frequency(y));
    }
  }
}

double Spectrum::alias(const Spectrum& truth) const {
  double beyond = 0, within = 0;
  for_waves([&](size_t i, double fx, double fy) {
    if (std::max(std::abs(fx), std::abs(fy)) > 0.5) {
      beyond += std::norm(wave_[i]);
    } else {
      within += std::norm(truth.wave_[i]);
    }
  });
  return std::sqrt(beyond / within);
}

double Spectrum::contrast(const Spectrum& truth, double low, double high) const {
  double common = 0, whole = 0;
  for_waves([&](size_t i, double fx, double fy) {
    const double size = std::hypot(fx, fy);
    if (size < low || size >= high) return;
    common += std::real(wave_[i] * std::conj(truth.wave_[i]));
    whole += std::norm(truth.wave_[i]);
  });
  return whole > 0 ? common / whole : 0;
}

Luminance interleaved(std::span<const Luminance> pictures, int per_px) {
  const Luminance& first = pictures[0];
  Luminance fine{first.width * per_px, first.height * per_px, {}};
  fine.value.resize(size_t(fine.width) * size_t(fine.height));
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      fine.at(x, y) = pictures[size_t(y % per_px * per_px + x % per_px)].at(x / per_px, y / per_px);
    }
  }
  return fine;
}

}  // namespace isosplat
