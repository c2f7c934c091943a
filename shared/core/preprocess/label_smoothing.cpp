#include "shared/core/preprocess/label_smoothing.h"

#include <algorithm>
#include <array>
#include <utility>

namespace isosplat {
namespace {

/// φ(t) is t up to this value, and 0 from twice this value on.
constexpr int16_t kSmall = 4 * kLabelVoxel;

/// The values at −2d, −d, d and 2d of a row of voxels.
struct Taps {
  const int16_t *before2, *before, *after, *after2;
};

constexpr int16_t limited(int16_t value, int16_t limit) {
  const int16_t raised = value < -limit ? static_cast<int16_t>(-limit) : value;
  return raised > limit ? limit : raised;
}

constexpr int16_t magnitude(int16_t value) {
  return value < 0 ? static_cast<int16_t>(-value) : value;
}

/// 16 bits suffice: |t| ≤ 16 · kLabelLimit = 24,576, and |w φ| ≤ 16 · kSmall = 16,384.
void smooth_row(const int16_t* values, const Taps& taps, size_t count, int16_t* __restrict to) {
  for (size_t x = 0; x < count; ++x) {
    const int16_t value = values[x], far = taps.before2[x], far2 = taps.after2[x];
    const auto near = static_cast<int16_t>(taps.before[x] + taps.after[x]);
    const auto t = static_cast<int16_t>(4 * near - far - far2 - 6 * value);
    const auto phi = static_cast<int16_t>(2 * limited(t, kSmall) - limited(t, 2 * kSmall));
    const auto farthest = std::max<int16_t>(magnitude(far), magnitude(far2));
    const auto sixteenths = static_cast<int16_t>((kLabelLimit - farthest) >> 6);
    const auto product = static_cast<int16_t>(phi * std::min<int16_t>(sixteenths, 16));
    // Division by 256 towards 0, so that the negative field gives the negative result.
    const auto change = static_cast<int16_t>((product + ((product >> 15) & 255)) >> 8);
    to[x] = on_side_of(value, static_cast<int16_t>(value + change));
  }
}

/// The value that lies `voxels` beyond the last one of a tile. Distances that are large there
/// increase further.
constexpr int16_t beyond(int16_t last, int32_t voxels) {
  constexpr int16_t kLarge = 3 * kLabelVoxel;
  const auto more = static_cast<int16_t>(voxels * kLabelVoxel);
  if (last >= kLarge) return std::min<int16_t>(static_cast<int16_t>(last + more), kLabelLimit);
  if (last <= -kLarge) return std::max<int16_t>(static_cast<int16_t>(last - more), -kLabelLimit);
  return last;
}

void smooth_along_x(LabelTile& tile, int32_t d) {
  constexpr int32_t kPad = 2 * kMaxSmoothingDistance;
  const int32_t n = tile.size.x;
  std::vector<int16_t> padded(static_cast<size_t>(n + 2 * kPad));
  for (int32_t z = 0; z < tile.size.z; ++z) {
    for (int32_t y = 0; y < tile.size.y; ++y) {
      const LabelTile::Range near = tile.near[tile.row_number(y, z)];
      if (near.begin == near.end) continue;
      const int16_t* const row = tile.values.data() + tile.row_begin(y, z);
      std::copy_n(row, n, padded.data() + kPad);
      for (int32_t i = 1; i <= 2 * d; ++i) {
        padded[static_cast<size_t>(kPad - i)] = beyond(row[0], i);
        padded[static_cast<size_t>(kPad + n - 1 + i)] = beyond(row[n - 1], i);
      }
      const int16_t* const at = padded.data() + kPad + near.begin;
      smooth_row(at, {at - 2 * d, at - d, at + d, at + 2 * d},
                 static_cast<size_t>(near.end - near.begin),
                 tile.other.data() + tile.row_begin(y, z) + near.begin);
    }
  }
  std::swap(tile.values, tile.other);
}

/// Along y (is_z false) or z.
void smooth_across(LabelTile& tile, int32_t d, bool is_z) {
  const int32_t n = is_z ? tile.size.z : tile.size.y;
  std::array<std::vector<int16_t>, 4> outside;
  for (auto& row : outside) row.resize(static_cast<size_t>(tile.size.x));
  for (int32_t z = 0; z < tile.size.z; ++z) {
    for (int32_t y = 0; y < tile.size.y; ++y) {
      const LabelTile::Range near = tile.near[tile.row_number(y, z)];
      if (near.begin == near.end) continue;
      const auto count = static_cast<size_t>(near.end - near.begin);
      const auto row_at = [&](int32_t p) {
        return tile.values.data() + (is_z ? tile.row_begin(y, p) : tile.row_begin(p, z)) +
               near.begin;
      };
      const auto tap = [&](size_t number, int32_t offset) -> const int16_t* {
        const int32_t at = (is_z ? z : y) + offset, inside = std::clamp(at, 0, n - 1);
        const int16_t* const row = row_at(inside);
        if (at == inside) return row;
        const int32_t voxels = at < inside ? inside - at : at - inside;
        int16_t* const extended = outside[number].data();
        for (size_t x = 0; x < count; ++x) extended[x] = beyond(row[x], voxels);
        return extended;
      };
      const Taps taps{tap(0, -2 * d), tap(1, -d), tap(2, d), tap(3, 2 * d)};
      smooth_row(row_at(is_z ? z : y), taps, count,
                 tile.other.data() + tile.row_begin(y, z) + near.begin);
    }
  }
  std::swap(tile.values, tile.other);
}

}  // namespace

void smooth_distances(LabelTile& tile, std::span<const int32_t> distances) {
  tile.other = tile.values;  // rows and voxels that are far from the border stay as they are
  for (const int32_t d : distances) {
    smooth_along_x(tile, d);
    smooth_across(tile, d, false);
    smooth_across(tile, d, true);
  }
}

}  // namespace isosplat
