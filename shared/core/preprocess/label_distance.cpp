#include "shared/core/preprocess/label_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isosplat {
namespace {

constexpr int32_t kReach = kLabelLimit / kLabelVoxel;

/// A squared distance that is too large to matter. Adding kReach² does not exceed a byte.
constexpr uint8_t kFar = 200;

/// The least squared distance that is limited to kLabelLimit: above (kReach + ½)².
constexpr uint8_t kLimited = kReach * kReach + kReach + 1;

/// The value of each squared distance.
std::array<int16_t, 256> distance_values() {
  std::array<int16_t, 256> values{};
  for (size_t i = 1; i < values.size(); ++i) {
    const double voxels = std::min<double>(std::sqrt(static_cast<double>(i)) - 0.5, kReach);
    values[i] = static_cast<int16_t>(voxels * kLabelVoxel);
  }
  return values;
}

/// The rows whose squared distances a row needs, at the offsets −kReach to kReach along an axis.
using Rows = std::array<const uint8_t*, 2 * kReach + 1>;

/// The minimum over the rows of squared distances.
void combine_rows(const Rows& rows, size_t count, uint8_t* __restrict to) {
  static_assert(kReach == 6);
  const auto [a6, a5, a4, a3, a2, a1, centre, b1, b2, b3, b4, b5, b6] = rows;
  const auto nearer = [](uint8_t least, uint8_t a, uint8_t b, int square) {
    const auto distance = static_cast<uint8_t>(std::min(a, b) + square);
    return std::min(least, distance);
  };
  for (size_t x = 0; x < count; ++x) {
    uint8_t least = nearer(centre[x], a1[x], b1[x], 1);
    least = nearer(least, a2[x], b2[x], 4);
    least = nearer(least, a3[x], b3[x], 9);
    least = nearer(least, a4[x], b4[x], 16);
    least = nearer(least, a5[x], b5[x], 25);
    to[x] = nearer(least, a6[x], b6[x], 36);
  }
}

/// What a row of squared distances holds.
enum class RowKind : uint8_t { all_far, all_zero, mixed };

/// Squared distances from the voxels of one side of the border. Keeps the rows of one slice, in
/// which the minimum along x is taken, and those of the tile.
class SideDistances {
 public:
  SideDistances(Index3 size, uint8_t* tile)
      : size_(size),
        row_(static_cast<size_t>(size.x)),
        padded_(row_ + 2 * kReach, kFar),
        far_(row_, kFar),
        slice_{std::vector<uint8_t>(row_ * static_cast<size_t>(size.y)),
               std::vector<RowKind>(static_cast<size_t>(size.y))},
        tile_kinds_(static_cast<size_t>(size.y) * static_cast<size_t>(size.z)),
        tile_(tile) {}

  /// The part of a slice along x. `distances`: for each voxel of the row, 0 or kFar.
  void add_row(int32_t y, const uint8_t* distances) {
    uint8_t any = 0, all = kFar;
    for (size_t x = 0; x < row_; ++x) {
      any |= distances[x];
      all &= distances[x];
    }
    RowKind& kind = slice_.kinds[static_cast<size_t>(y)];
    kind = any == 0 ? RowKind::all_zero : all == kFar ? RowKind::all_far : RowKind::mixed;
    uint8_t* const to = slice_.distances.data() + row_ * static_cast<size_t>(y);
    if (kind != RowKind::mixed) {
      std::copy_n(distances, row_, to);
      return;
    }
    std::copy_n(distances, row_, padded_.data() + kReach);
    Rows rows;
    for (size_t i = 0; i < rows.size(); ++i) rows[i] = padded_.data() + i;
    combine_rows(rows, row_, to);
  }

  /// The part along y, after all rows of the slice were added.
  void end_slice(int32_t z) {
    for (int32_t y = 0; y < size_.y; ++y) {
      const size_t number = row_number(y, z);
      tile_kinds_[number] = combine(y, size_.y, tile_ + number * row_, [&](int32_t other) -> Row {
        const auto at = static_cast<size_t>(other);
        return {slice_.distances.data() + at * row_, slice_.kinds[at]};
      });
    }
  }

  /// The part along z, after all slices have ended.
  RowKind finish_row(int32_t y, int32_t z, uint8_t* to) const {
    return combine(z, size_.z, to, [&](int32_t other) -> Row {
      const size_t number = row_number(y, other);
      return {tile_ + number * row_, tile_kinds_[number]};
    });
  }

 private:
  struct Row {
    const uint8_t* distances;
    RowKind kind;
  };
  struct Slice {
    std::vector<uint8_t> distances;
    std::vector<RowKind> kinds;
  };

  size_t row_number(int32_t y, int32_t z) const {
    return static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y);
  }

  template <class F>
  RowKind combine(int32_t position, int32_t count, uint8_t* to, const F& row_at) const {
    Rows rows;
    bool is_far = true;
    for (size_t i = 0; i < rows.size(); ++i) {
      const int32_t at = position + static_cast<int32_t>(i) - kReach;
      rows[i] = far_.data();
      if (at < 0 || at >= count) continue;
      const Row row = row_at(at);
      rows[i] = row.distances;
      is_far = is_far && row.kind == RowKind::all_far;
    }
    const RowKind own = row_at(position).kind;
    if (is_far || own == RowKind::all_zero) {
      std::fill_n(to, row_, is_far ? kFar : uint8_t{0});
      return is_far ? RowKind::all_far : own;
    }
    combine_rows(rows, row_, to);
    return RowKind::mixed;
  }

  Index3 size_;
  size_t row_;
  std::vector<uint8_t> padded_, far_;
  Slice slice_;
  std::vector<RowKind> tile_kinds_;
  uint8_t* tile_;
};

/// For each voxel of a row: 0 if it has the label, else kFar.
void find_label(const LabelVolume& volume, uint16_t label, const LabelTile& tile, int32_t y,
                int32_t z, std::vector<uint8_t>& to) {
  std::fill(to.begin(), to.end(), label == 0 ? uint8_t{0} : kFar);
  y += tile.first.y;
  z += tile.first.z;
  if (y < 0 || z < 0 || y >= volume.size.y || z >= volume.size.z) return;
  const int32_t begin = std::max(tile.first.x, 0);
  const int32_t end = std::min(tile.first.x + tile.size.x, volume.size.x);
  const uint16_t* const row = volume.row(y, z);
  for (int32_t x = begin; x < end; ++x) {
    to[static_cast<size_t>(x - tile.first.x)] = row[x] == label ? 0 : kFar;
  }
}

/// The values of a row, from its squared distances. One of the two is 0 for each voxel.
LabelTile::Range to_values(const uint8_t* from_rest, const uint8_t* from_label, size_t count,
                           int16_t* to) {
  static const std::array<int16_t, 256> kValues = distance_values();
  size_t begin = count, end = 0;
  for (size_t x = 0; x < count; ++x) {
    to[x] = static_cast<int16_t>(kValues[from_rest[x]] - kValues[from_label[x]]);
    if (from_rest[x] + from_label[x] < kLimited) {
      begin = std::min(begin, x);
      end = x + 1;
    }
  }
  if (begin >= end) return {};
  return {static_cast<int32_t>(begin), static_cast<int32_t>(end)};
}

}  // namespace

void compute_distances(const LabelVolume& volume, uint16_t label, LabelTile& tile) {
  const auto row = static_cast<size_t>(tile.size.x);
  tile.values.resize(tile.voxels());
  tile.other.resize(tile.voxels());
  tile.near.assign(tile.row_number(0, tile.size.z), {});
  auto* const bytes = reinterpret_cast<uint8_t*>(tile.other.data());
  SideDistances label_side(tile.size, bytes), rest_side(tile.size, bytes + tile.voxels());
  std::vector<uint8_t> from_label(row), from_rest(row);
  for (int32_t z = 0; z < tile.size.z; ++z) {
    for (int32_t y = 0; y < tile.size.y; ++y) {
      find_label(volume, label, tile, y, z, from_label);
      for (size_t x = 0; x < row; ++x) from_rest[x] = from_label[x] ^ kFar;
      label_side.add_row(y, from_label.data());
      rest_side.add_row(y, from_rest.data());
    }
    label_side.end_slice(z);
    rest_side.end_slice(z);
  }
  for (int32_t z = 0; z < tile.size.z; ++z) {
    for (int32_t y = 0; y < tile.size.y; ++y) {
      int16_t* const to = tile.values.data() + tile.row_begin(y, z);
      if (label_side.finish_row(y, z, from_label.data()) == RowKind::all_far) {
        std::fill_n(to, row, static_cast<int16_t>(-kLabelLimit));
      } else if (rest_side.finish_row(y, z, from_rest.data()) == RowKind::all_far) {
        std::fill_n(to, row, kLabelLimit);
      } else {
        tile.near[tile.row_number(y, z)] = to_values(from_rest.data(), from_label.data(), row, to);
      }
    }
  }
}

}  // namespace isosplat
