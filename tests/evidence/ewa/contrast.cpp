#include "tests/evidence/ewa/contrast.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace isosplat {
namespace {

constexpr int kHighestOrder = 15;
constexpr int kMargin = 4;  // px

double luminance_at(const Checker& checker, const Signal& signal, double g) {
  return luminance_of(signal({0, 0, checker.plane()}, {0, 0, g}));
}

bool is_beyond_nyquist(Vec2d frequency) {
  return std::max(std::abs(frequency.x), std::abs(frequency.y)) > 0.5;
}

bool has_no_visible_wave(const Checker& checker, const ImagePlane& image, Vec3d point) {
  for (int m = 1; m <= kHighestOrder; m += 2) {
    for (int n = -kHighestOrder; n <= kHighestOrder; n += 2) {
      if (!is_beyond_nyquist(checker.frequency(image, point, m, n))) return false;
    }
  }
  return true;
}

/// Whether all pixels within kMargin show the plane.
bool is_inside(const Checker& checker, const ImagePlane& image, int x, int y) {
  for (const int dy : {-kMargin, 0, kMargin}) {
    for (const int dx : {-kMargin, 0, kMargin}) {
      const auto point = checker.point_at(image, {x + dx + 0.5, y + dy + 0.5});
      if (!point || !checker.holds(*point, 1)) return false;
    }
  }
  return true;
}

}  // namespace

CheckerLevels levels_of(const Checker& checker, const render::Camera& camera) {
  const Signal signal = checker.signal(camera);
  CheckerLevels levels;
  levels.dark = luminance_at(checker, signal, Checker::kLow);
  levels.bright = luminance_at(checker, signal, Checker::kHigh);
  // The levels of the bilinear pattern, over a period of two squares.
  constexpr int kSteps = 16;
  const auto g = [&](int x, int y) {
    return ((x / checker.square + y / checker.square) % 2 ? Checker::kHigh : Checker::kLow);
  };
  const int period = 2 * checker.square, side = period * kSteps;
  double sum = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double s = (x % kSteps + 0.5) / kSteps, t = (y % kSteps + 0.5) / kSteps;
      const int i = x / kSteps, j = y / kSteps;
      sum += luminance_at(checker, signal,
                          (1 - t) * ((1 - s) * g(i, j) + s * g(i + 1, j)) +
                              t * ((1 - s) * g(i, j + 1) + s * g(i + 1, j + 1)));
    }
  }
  levels.mean = sum / (double(side) * side);
  return levels;
}

double checker_alias(const Luminance& picture, const Checker& checker, const ImagePlane& image,
                     const CheckerLevels& levels, size_t* pixels) {
  double sum = 0;
  size_t count = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto point = checker.point_at(image, {x + 0.5, y + 0.5});
      if (!point || !has_no_visible_wave(checker, image, *point) ||
          !is_inside(checker, image, x, y)) {
        continue;
      }
      const double difference = picture.at(x, y) - levels.mean;
      sum += difference * difference;
      ++count;
    }
  }
  if (pixels) *pixels = count;
  return std::sqrt(sum / std::max<double>(1, double(count))) /
         (0.5 * (levels.bright - levels.dark));
}

double wave_amplitude(const Luminance& picture, int per_px, const Checker& checker,
                      const ImagePlane& image, const CheckerLevels& levels, double low,
                      double high) {
  std::complex<double> sums[2];
  size_t counts[2] = {0, 0};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Vec2d place{(x + 0.5) / per_px, (y + 0.5) / per_px};
      // All squares of a pixel belong to the same range of frequencies, or none.
      const auto middle =
          checker.point_at(image, {std::floor(place.x) + 0.5, std::floor(place.y) + 0.5});
      const auto point = checker.point_at(image, place);
      if (!point || !middle || !checker.holds(*middle, 2 * checker.square)) continue;
      for (int wave = 0; wave < 2; ++wave) {
        const int n = wave == 0 ? 1 : -1;
        const Vec2d frequency = checker.frequency(image, *middle, 1, n);
        const double size = std::hypot(frequency.x, frequency.y);
        if (size < low || size >= high) continue;
        sums[wave] += (picture.at(x, y) - levels.mean) *
                      std::polar(1.0, -2 * std::numbers::pi * checker.phase(*point, 1, n));
        ++counts[wave];
      }
    }
  }
  // Weight the waves by the number of their pixels, since different orientations occur.
  const double total = double(counts[0] + counts[1]);
  return total > 0 ? (std::abs(sums[0]) + std::abs(sums[1])) / total : 0;
}

double edge_width(const Luminance& picture, int per_px, const Checker& checker,
                  const ImagePlane& image, const CheckerLevels& levels) {
  constexpr double kBin = 1.0 / 16;  // px
  const Vec2d by_x = image.derivative({0, 0, checker.plane()}, {1, 0, 0});
  const double px_per_cell = std::hypot(by_x.x, by_x.y);
  const double reach = 0.5 * checker.square * px_per_cell;
  const auto bins = static_cast<size_t>(std::ceil(2 * reach / kBin));
  std::vector<double> sum(bins, 0.0), count(bins, 0.0);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto point = checker.point_at(image, {(x + 0.5) / per_px, (y + 0.5) / per_px});
      if (!point || !checker.holds(*point, checker.square)) continue;
      // Edges are where the lattice points change, half a cell before each multiple of a square.
      const double s = (point->x + 0.5) / checker.square, t = (point->y + 0.5) / checker.square;
      const double edge = std::round(s);
      // Use only the middle half of an edge, away from corners.
      if (std::abs(t - std::floor(t) - 0.5) > 0.25) continue;
      const bool rises = static_cast<int64_t>(std::floor(t) + edge) % 2 != 0;
      const double distance = (s - edge) * checker.square * px_per_cell * (rises ? 1 : -1);
      const auto bin =
          static_cast<size_t>(std::clamp((distance + reach) / kBin, 0.0, double(bins) - 1));
      sum[bin] += picture.at(x, y);
      count[bin] += 1;
    }
  }
  const auto crossing = [&](double share) {
    const double level = levels.dark + share * (levels.bright - levels.dark);
    // Searches from the bright end for the first bin below the level, and interpolates.
    double previous = 0, at_previous = 0;
    bool has_previous = false;
    for (size_t i = bins; i-- > 0;) {
      if (count[i] == 0) continue;
      const double mean = sum[i] / count[i], at = (double(i) + 0.5) * kBin - reach;
      if (mean < level) {
        if (!has_previous) return at;
        return at + (at_previous - at) * (level - mean) / (previous - mean);
      }
      previous = mean;
      at_previous = at;
      has_previous = true;
    }
    return -reach;
  };
  return crossing(0.9) - crossing(0.1);
}

}  // namespace isosplat
