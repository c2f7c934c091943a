#include "shared/core/preprocess/label_balance.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace isosplat {
namespace {

constexpr int32_t kBrick = 4;  ///< cells along an axis
constexpr int32_t kFine = 16;  ///< a shift's units per unit of a distance
constexpr int32_t kMaxShift = 3 * kFine * kLabelVoxel / 10;
/// The sum of the weights of Bricks::smooth().
constexpr int32_t kSmoothing = 9 * 9 * 9;

constexpr int32_t kPoints = 4;  ///< along each axis of a cell

/// Values of corners are rounded to 1/32 voxel and limited to 63, so that a sum with the weights of
/// a point, which add up to 8³, fits in 16 bits.
constexpr int16_t kCornerStep = kLabelVoxel / 32;
constexpr int16_t kMaxCorner = 63;

/// Points nearer to the border than 1/8 voxel measure its area.
constexpr int16_t kNear = 4 * 8 * 8 * 8;

struct BrickSums {
  int32_t missing = 0;  ///< volume of the voxels less the volume enclosed, in 1/128 voxels
  int32_t area = 0;     ///< points that are nearer to the border than 1/8 voxel: 16 per voxel²
};

/// The values of a cell's corners, x fastest.
using Corners = std::array<int16_t, 8>;

/// Numbers of points of a cell: twice the number of those inside (a point on the border counts
/// once), and the number of those near the border.
struct PointCounts {
  int32_t inside2 = 0, near = 0;
};

template <size_t count>
void between(const int16_t* low, const int16_t* high, int32_t point, int16_t* to) {
  const auto of_high = static_cast<int16_t>(2 * point + 1);
  const auto of_low = static_cast<int16_t>(2 * kPoints - of_high);
  for (size_t i = 0; i < count; ++i) {
    to[i] = static_cast<int16_t>(of_low * low[i] + of_high * high[i]);
  }
}

PointCounts count_points(const Corners& corners) {
  constexpr size_t kP = kPoints;
  std::array<std::array<int16_t, kP>, 4> along_x;
  for (size_t edge = 0; edge < 4; ++edge) {
    for (size_t i = 0; i < kP; ++i) {
      between<1>(&corners[2 * edge], &corners[2 * edge + 1], static_cast<int32_t>(i),
                 &along_x[edge][i]);
    }
  }
  std::array<std::array<int16_t, kP * kP>, 2> along_y;
  for (size_t k = 0; k < 2; ++k) {
    for (size_t j = 0; j < kP; ++j) {
      between<kP>(along_x[2 * k].data(), along_x[2 * k + 1].data(), static_cast<int32_t>(j),
                  &along_y[k][kP * j]);
    }
  }
  std::array<int16_t, kP * kP> inside2{}, near{}, plane;
  for (int32_t k = 0; k < kPoints; ++k) {
    between<kP * kP>(along_y[0].data(), along_y[1].data(), k, plane.data());
    for (size_t i = 0; i < plane.size(); ++i) {
      const int16_t value = plane[i];
      inside2[i] = static_cast<int16_t>(inside2[i] + (value > 0 ? 1 : 0) + (value >= 0 ? 1 : 0));
      near[i] = static_cast<int16_t>(near[i] + (value < kNear && value > -kNear ? 1 : 0));
    }
  }
  PointCounts counts;
  for (size_t i = 0; i < plane.size(); ++i) {
    counts.inside2 += inside2[i];
    counts.near += near[i];
  }
  return counts;
}

/// The bricks of a tile.
class Bricks {
 public:
  explicit Bricks(Index3 voxels)
      : size_{along(voxels.x), along(voxels.y), along(voxels.z)},
        sums_(index(0, 0, size_.z)),
        shifts_(sums_.size()) {}

  BrickSums& at_cell(int32_t x, int32_t y, int32_t z) {
    return sums_[index(x / kBrick, y / kBrick, z / kBrick)];
  }

  /// A brick's missing volume is divided by the smoothed area, and the quotients are smoothed. So
  /// the shifts add just the missing volume, because the smoothing is symmetric: the volume that is
  /// missing in a brick is added by the bricks around it.
  void find_shifts() {
    std::vector<int32_t> area(sums_.size());
    for (size_t i = 0; i < sums_.size(); ++i) area[i] = kFine * sums_[i].area;
    smooth(area);
    for (size_t i = 0; i < sums_.size(); ++i) {
      // missing/128 voxels over area/16 voxels² are missing / (8 area) voxels. If no point is near
      // the border, the area counts as 1, and the limit decides the shift.
      const int64_t shift =
          int64_t{kLabelVoxel / 8 * kFine * kFine} * sums_[i].missing / std::max(area[i], kFine);
      constexpr int64_t kMost = int64_t{kMaxShift} * kSmoothing;
      shifts_[i] = static_cast<int32_t>(std::clamp(shift, -kMost, kMost));
    }
    smooth(shifts_);
    for (int32_t& shift : shifts_) shift = std::clamp(shift, -kMaxShift, kMaxShift);
  }

  /// The shifts of a row of voxels at the middles of its bricks along x, multiplied by kBrick².
  /// Returns whether any is not 0.
  bool shifts_of_row(int32_t y, int32_t z, std::vector<int32_t>& to) const {
    const Between by = between_bricks(y, size_.y), bz = between_bricks(z, size_.z);
    to.resize(static_cast<size_t>(size_.x));
    int32_t any = 0;
    for (int32_t x = 0; x < size_.x; ++x) {
      const auto at = [&](int32_t j, int32_t k) { return shifts_[index(x, j, k)]; };
      const int32_t low = (kBrick - by.part) * at(by.low, bz.low) + by.part * at(by.high, bz.low);
      const int32_t high =
          (kBrick - by.part) * at(by.low, bz.high) + by.part * at(by.high, bz.high);
      const int32_t shift = (kBrick - bz.part) * low + bz.part * high;
      to[static_cast<size_t>(x)] = shift;
      any |= shift;
    }
    return any != 0;
  }

  /// The two bricks between whose middles a voxel lies, and by how many voxels it is beyond the
  /// middle of the lower one.
  struct Between {
    int32_t low, high, part;
  };
  static Between between_bricks(int32_t voxel, int32_t bricks) {
    const int32_t from_first = voxel - kBrick / 2 + kBrick;  // not negative
    const int32_t low = from_first / kBrick - 1;
    return {std::clamp(low, 0, bricks - 1), std::clamp(low + 1, 0, bricks - 1),
            from_first % kBrick};
  }

 private:
  static int32_t along(int32_t voxels) { return (voxels - 2) / kBrick + 1; }
  size_t index(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y)) *
               static_cast<size_t>(size_.x) +
           static_cast<size_t>(x);
  }

  /// Smooths with (1, 2, 3, 2, 1)/9 along each axis, twice. Less smoothing would follow the steps
  /// of gentle slopes. Division rounds towards 0, so that the negative values give the negative
  /// result.
  void smooth(std::vector<int32_t>& values) const {
    for (int round = 0; round < 2; ++round) {
      smooth(values, 1, size_.x);
      smooth(values, index(0, 1, 0), size_.y);
      smooth(values, index(0, 0, 1), size_.z);
      for (int32_t& value : values) value /= kSmoothing;
    }
  }

  static void smooth(std::vector<int32_t>& values, size_t stride, int32_t count) {
    const size_t whole = stride * static_cast<size_t>(count);
    std::vector<int32_t> line(static_cast<size_t>(count) + 4);
    for (size_t begin = 0; begin < values.size(); begin += whole) {
      for (size_t first = begin; first < begin + stride; ++first) {
        for (size_t i = 0; i < static_cast<size_t>(count); ++i)
          line[i + 2] = values[first + i * stride];
        for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
          values[first + i * stride] =
              line[i] + 2 * line[i + 1] + 3 * line[i + 2] + 2 * line[i + 3] + line[i + 4];
        }
      }
    }
  }

  Index3 size_;
  std::vector<BrickSums> sums_;
  std::vector<int32_t> shifts_;
};

/// Adds the cells between the rows y, y + 1 and z, z + 1 that the border crosses.
void add_cells(const LabelTile& tile, int32_t y, int32_t z, std::vector<uint8_t>& inside,
               Bricks& bricks) {
  std::array<const int16_t*, 4> rows;
  int32_t begin = tile.size.x, end = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    const int32_t j = y + static_cast<int32_t>(i % 2), k = z + static_cast<int32_t>(i / 2);
    rows[i] = tile.values.data() + tile.row_begin(j, k);
    const LabelTile::Range near = tile.near[tile.row_number(j, k)];
    if (near.begin == near.end) continue;
    begin = std::min(begin, near.begin);
    end = std::max(end, near.end);
  }
  // The number of voxels inside, of the four at x.
  for (int32_t x = begin; x < end; ++x) {
    int count = 0;
    for (const int16_t* row : rows) count += row[x] > 0 ? 1 : 0;
    inside[static_cast<size_t>(x)] = static_cast<uint8_t>(count);
  }
  for (int32_t x = begin; x + 1 < end; ++x) {
    const int32_t count = inside[static_cast<size_t>(x)] + inside[static_cast<size_t>(x + 1)];
    if (count == 0 || count == 8) continue;
    Corners corners;
    for (size_t i = 0; i < corners.size(); ++i) {
      const auto value =
          static_cast<int16_t>(rows[i / 2][x + static_cast<int32_t>(i % 2)] / kCornerStep);
      corners[i] = std::clamp<int16_t>(value, -kMaxCorner, kMaxCorner);
    }
    const PointCounts points = count_points(corners);
    BrickSums& brick = bricks.at_cell(x, y, z);
    brick.missing += 16 * count - points.inside2;
    brick.area += points.near;
  }
}

/// Shifts the voxels of a row. `shifts`: of shifts_of_row().
void shift_row(const std::vector<int32_t>& shifts, LabelTile::Range near, int16_t* row) {
  const auto bricks = static_cast<int32_t>(shifts.size());
  for (int32_t x = near.begin; x < near.end; ++x) {
    const auto [low, high, part] = Bricks::between_bricks(x, bricks);
    constexpr int32_t kDivisor = kBrick * kBrick * kBrick * kFine;
    const int32_t sum = (kBrick - part) * shifts[static_cast<size_t>(low)] +
                        part * shifts[static_cast<size_t>(high)];
    const int32_t shift = (sum + (sum < 0 ? -kDivisor / 2 : kDivisor / 2)) / kDivisor;
    row[x] = on_side_of(row[x], static_cast<int16_t>(row[x] + shift));
  }
}

}  // namespace

void balance_volume(LabelTile& tile, int32_t rounds) {
  std::vector<uint8_t> inside(static_cast<size_t>(tile.size.x));
  std::vector<int32_t> shifts;
  for (int32_t round = 0; round < rounds; ++round) {
    Bricks bricks(tile.size);
    for (int32_t z = 0; z + 1 < tile.size.z; ++z) {
      for (int32_t y = 0; y + 1 < tile.size.y; ++y) add_cells(tile, y, z, inside, bricks);
    }
    bricks.find_shifts();
    for (int32_t z = 0; z < tile.size.z; ++z) {
      for (int32_t y = 0; y < tile.size.y; ++y) {
        const LabelTile::Range near = tile.near[tile.row_number(y, z)];
        if (near.begin == near.end || !bricks.shifts_of_row(y, z, shifts)) continue;
        shift_row(shifts, near, tile.values.data() + tile.row_begin(y, z));
      }
    }
  }
}

}  // namespace isosplat
