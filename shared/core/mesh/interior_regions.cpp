#include "shared/core/mesh/interior_regions.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

/// Heights in (0, 1) at which the parts of a slice may change, in ascending order, after a 0 and
/// before a 1.
struct Heights {
  std::array<double, 8> at{0};
  int count = 1;

  void add(double height) {
    if (height > 0 && height < 1) at[static_cast<size_t>(count++)] = height;
  }
  void close() {
    at[static_cast<size_t>(count++)] = 1;
    std::sort(at.begin(), at.begin() + count);
  }
};

/// Adds the heights at which the saddle of the slice's bilinear function is 0: the roots of
/// p(t) s(t) − q(t) r(t), where p, q, r, s are linear in t.
void add_saddles(const std::array<double, 8>& v, Heights& heights) {
  const double dp = v[4] - v[0], dq = v[5] - v[1], dr = v[6] - v[2], ds = v[7] - v[3];
  const double a = dp * ds - dq * dr;
  const double b = v[0] * ds + v[3] * dp - v[1] * dr - v[2] * dq;
  const double c = v[0] * v[3] - v[1] * v[2];
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  if (a != 0) heights.add(q / a);
  if (q != 0) heights.add(c / q);
}

using Slice = std::array<double, 4>;

/// Whether the diagonal corners 0 and 3 are connected by points of their own sign, where 1 and 2
/// have the other sign.
bool is_connected(const Slice& s) {
  return s[0] > 0 ? s[0] * s[3] > s[1] * s[2] : s[1] * s[2] <= s[0] * s[3];
}

}  // namespace

std::array<int, 8> interior_regions(const std::array<double, 8>& v) {
  Heights heights;
  for (size_t corner = 0; corner < 4; ++corner) {
    const double low = v[corner], high = v[corner + 4];
    if ((low > 0) != (high > 0)) heights.add(low / (low - high));
  }
  add_saddles(v, heights);
  heights.close();
  SmallSets<28> sets;  // of four corners in each of up to seven layers of slices
  std::array<bool, 4> below{};
  const int layers = heights.count - 1;
  for (int layer = 0; layer < layers; ++layer) {
    const auto i = static_cast<size_t>(layer);
    const double t = 0.5 * (heights.at[i] + heights.at[i + 1]);
    Slice slice;
    std::array<bool, 4> is_high{};
    for (size_t corner = 0; corner < 4; ++corner) {
      slice[corner] = v[corner] + t * (v[corner + 4] - v[corner]);
      is_high[corner] = slice[corner] > 0;
      if (layer > 0 && is_high[corner] == below[corner]) {
        sets.unite(4 * layer + int(corner), 4 * (layer - 1) + int(corner));
      }
    }
    constexpr std::array<std::array<int, 2>, 4> kSides{{{0, 1}, {1, 3}, {3, 2}, {2, 0}}};
    for (const auto [a, b] : kSides) {
      if (is_high[size_t(a)] == is_high[size_t(b)]) sets.unite(4 * layer + a, 4 * layer + b);
    }
    const bool is_ambiguous =
        is_high[0] == is_high[3] && is_high[1] == is_high[2] && is_high[0] != is_high[1];
    if (is_ambiguous) {
      const bool first = is_connected(slice);
      sets.unite(4 * layer + (first ? 0 : 1), 4 * layer + (first ? 3 : 2));
    }
    below = is_high;
  }
  std::array<int, 8> regions{};
  for (int corner = 0; corner < 4; ++corner) {
    regions[size_t(corner)] = sets.find(corner);
    regions[size_t(corner) + 4] = sets.find(4 * (layers - 1) + corner);
  }
  return regions;
}

}  // namespace isosplat
