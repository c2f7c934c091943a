#include "shared/core/preprocess/distance_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "shared/core/codec/chunk_header.h"
#include "shared/core/preprocess/coarse_voxels.h"

namespace isosplat {
namespace {

constexpr int32_t kReach = 2, kAcross = 2 * kReach + 1;
constexpr size_t kNear = kAcross * kAcross * kAcross, kMiddle = kNear / 2;

/// The least half thickness that coarse voxels, two voxels apart, are sure to show, in 1/8 voxel:
/// of sheets (1 voxel), and of tubes (√2 voxels).
constexpr int32_t kSheet = 9, kTube = 12;

/// Distances are computed in 1/64 of a step, because the weights of an average sum to 64.
constexpr int32_t kUnits = 64;

/// The distances of the voxels around a coarse voxel from the surface, in steps, x fastest.
using Near = std::array<int32_t, kNear>;

/// What is the same around each coarse voxel.
struct Surroundings {
  /// Of each voxel of Near: its distance from the middle in 1/64 voxel.
  std::array<int32_t, kNear> distance;
  /// The 13 pairs of opposite neighbours: the first of each pair, and its weight in the average.
  std::array<std::pair<size_t, int32_t>, 13> pairs;

  Surroundings() {
    size_t n = 0, pair = 0;
    for (int32_t z = -kReach; z <= kReach; ++z) {
      for (int32_t y = -kReach; y <= kReach; ++y) {
        for (int32_t x = -kReach; x <= kReach; ++x, ++n) {
          distance[n] =
              static_cast<int32_t>(std::lround(kUnits * std::sqrt(double(x * x + y * y + z * z))));
          const auto along = [](int32_t i) { return std::max(2 - std::abs(i), 0); };
          const int32_t weight = along(x) * along(y) * along(z);
          if (n < kMiddle && weight > 0) pairs[pair++] = {n, weight};
        }
      }
    }
  }
};

/// The average around the middle, which is not at the limit.
int32_t average(const Near& near, const Surroundings& around, int32_t limit) {
  int32_t sum = 8 * near[kMiddle];
  for (const auto& [i, weight] : around.pairs) {
    const int32_t a = near[i], b = near[kNear - 1 - i];
    const bool is_limited = std::max(std::abs(a), std::abs(b)) >= limit;
    sum += weight * (is_limited ? 2 * near[kMiddle] : a + b);
  }
  return sum;
}

/// The distance of the middle, which is at the limit, over the nearest voxel that is not.
int32_t extended(const Near& near, const Surroundings& around, const DistanceSteps& steps) {
  const int32_t side = near[kMiddle] < 0 ? -1 : 1, most = 4 * steps.per_voxel * kUnits;
  int32_t least = most;
  for (size_t i = 0; i < kNear; ++i) {
    const int32_t over = kUnits * side * near[i] + around.distance[i] * steps.per_voxel;
    least = std::min(least, side * near[i] < steps.limit ? over : most);
  }
  return side * std::max(least, kUnits * steps.limit);
}

/// Whether the coarse voxels before and after a coarse voxel, along each axis, are on a face of the
/// volume. Those are never inside.
struct FacesNear {
  std::array<bool, 3> before, after;
};

/// Whether a voxel inside would be lost if the middle stayed outside: the voxel is in a coarse cell
/// of the middle, and no coarse voxel of the cells around it is further inside than the middle.
bool must_be_inside(const Near& near, const FacesNear& faces) {
  const auto at = [&](int32_t x, int32_t y, int32_t z) {
    return near[static_cast<size_t>(((z + kReach) * kAcross + y + kReach) * kAcross + x + kReach)];
  };
  // The step to the next coarse voxel on a side: none if that is on a face.
  const auto step = [&](size_t axis, int32_t side) {
    return (side < 0 && faces.before[axis]) || (side > 0 && faces.after[axis]) ? 0 : 2 * side;
  };
  for (int32_t z = -1; z <= 1; ++z) {
    for (int32_t y = -1; y <= 1; ++y) {
      for (int32_t x = -1; x <= 1; ++x) {
        if (at(x, y, z) <= 0) continue;
        const int32_t i = step(0, x), j = step(1, y), k = step(2, z);
        const int32_t most = std::max({at(i, 0, 0), at(0, j, 0), at(0, 0, k), at(i, j, 0),
                                       at(i, 0, k), at(0, j, k), at(i, j, k)});
        if (most <= near[kMiddle]) return true;
      }
    }
  }
  return false;
}

/// A distance in 1/64 of a step, in the steps of the coarser level, whose voxels are two voxels
/// long.
int32_t coarse_steps(int32_t distance, const DistanceSteps& steps) {
  const int32_t divisor = 2 * kUnits * steps.per_voxel;
  const int32_t doubled = 2 * std::abs(distance) * kCoarseDistances.per_voxel;
  const int32_t rounded = std::min((doubled + divisor) / (2 * divisor), kCoarseDistances.limit);
  return distance < 0 ? -rounded : rounded;
}

/// The distance of a coarse voxel in steps of kCoarseDistances. deepest: the greatest of near.
int32_t coarse_distance(const Near& near, int32_t deepest, const FacesNear& faces,
                        const Surroundings& around, const DistanceSteps& steps) {
  const bool is_limited = std::abs(near[kMiddle]) >= steps.limit;
  int32_t distance =
      is_limited ? extended(near, around, steps) : average(near, around, steps.limit);
  const int32_t own = is_limited ? distance : kUnits * near[kMiddle];
  // The half thickness of the structure near the coarse voxel. The lower bound is for structures
  // whose middle lies between the voxels.
  const int32_t half = std::max(deepest, steps.per_voxel / 2);
  const auto thickened = [&](int32_t eighths) {
    return own + kUnits * (eighths * steps.per_voxel / 8 - half);
  };
  if (deepest > 0 && 8 * half < kSheet * steps.per_voxel) {
    distance = std::max(distance, thickened(kSheet));
  }
  // At the surface, a coarse voxel counts as outside.
  if (deepest > 0 && coarse_steps(distance, steps) <= 0 && must_be_inside(near, faces)) {
    distance = std::max(thickened(kTube), kUnits * steps.per_voxel / 4);
  }
  return coarse_steps(distance, steps);
}

}  // namespace

void DistanceLevels::coarsen_voxels(const Layer& layer, const GatheredBlock& block,
                                    const CoarserLayer& coarser) const {
  static const Surroundings kAround;
  const DistanceSteps& steps = layer.grid.level == 0 ? finest_ : kCoarseDistances;
  const int32_t isovalue = *layer.only_isovalue;
  const Index3 cells = layer.grid.cells, coarse = coarser.grid.cells;
  const auto* voxels = reinterpret_cast<const uint8_t*>(layer.voxels);
  auto* out = reinterpret_cast<uint8_t*>(coarser.voxels);
  const LevelBox written = coarse_voxels_of(layer.grid, block.index);
  const Index3 first = written.first, end = written.end();
  const int32_t first_x = std::max(2 * first.x - kReach, 0);
  const int32_t last_x = std::min(2 * (end.x - 1) + kReach, cells.x);
  const auto count = static_cast<size_t>(last_x - first_x + 1);
  std::array<const uint8_t*, kAcross * kAcross> rows;
  std::array<uint8_t, kBlockCells + 2 * kReach + 1> low, high;
  Near near;
  const auto distance_at = [&](Index3 at) {
    const auto x_at = finer_voxels<kReach>(at.x, cells.x);
    int32_t least = 255, most = 0;
    for (const int32_t x : x_at) {
      least = std::min<int32_t>(least, low[static_cast<size_t>(x - first_x)]);
      most = std::max<int32_t>(most, high[static_cast<size_t>(x - first_x)]);
    }
    if (most - isovalue <= -steps.limit) return -kCoarseDistances.limit;
    if (least - isovalue >= steps.limit) return kCoarseDistances.limit;
    size_t n = 0;
    if (x_at.back() - x_at.front() == 2 * kReach) {
      for (const uint8_t* const row : rows) {
        const uint8_t* const from = row + (x_at.front() - first_x);
        for (size_t x = 0; x < kAcross; ++x) near[n++] = from[x] - isovalue;
      }
    } else {
      for (const uint8_t* const row : rows) {
        for (const int32_t x : x_at) near[n++] = row[x - first_x] - isovalue;
      }
    }
    const FacesNear faces{{at.x == 1, at.y == 1, at.z == 1},
                          {at.x + 1 == coarse.x, at.y + 1 == coarse.y, at.z + 1 == coarse.z}};
    return coarse_distance(near, most - isovalue, faces, kAround, steps);
  };
  for (int32_t k = first.z; k < end.z; ++k) {
    const auto z_rows = finer_voxels<kReach>(k, cells.z);
    for (int32_t j = first.y; j < end.y; ++j) {
      const auto y_rows = finer_voxels<kReach>(j, cells.y);
      low.fill(255);
      high.fill(0);
      for (size_t r = 0; r < rows.size(); ++r) {
        rows[r] = voxels + layer.voxel_box.at({first_x, y_rows[r % kAcross], z_rows[r / kAcross]});
        for (size_t x = 0; x < count; ++x) {
          low[x] = std::min(low[x], rows[r][x]);
          high[x] = std::max(high[x], rows[r][x]);
        }
      }
      uint8_t* const to = out + coarser.voxel_box.at({first.x, j, k});
      for (int32_t i = first.x; i < end.x; ++i) {
        const bool is_first = i == 0 || j == 0 || k == 0;
        const bool is_last = i == coarse.x || j == coarse.y || k == coarse.z;
        int32_t distance = distance_at({i, j, k});
        // The last voxel of an axis may lie within the last cell.
        if (is_last && distance > 0) distance = -kCoarseDistances.limit;
        if (is_first) distance = std::min(distance, -1);
        to[i - first.x] = static_cast<uint8_t>(isovalue + distance);
      }
    }
  }
}

void DistanceLevels::set_intervals(const Layer& layer, GatheredBlock& block) const {
  const int32_t isovalue = *layer.only_isovalue;
  constexpr auto kLow = static_cast<QuantizedValue>((1 << kMaxIntervalShift) - 1);
  const auto row = static_cast<size_t>(block.cells.x + 1);
  const size_t slice = row * static_cast<size_t>(block.cells.y + 1);
  CellInterval* interval = block.intervals.data();
  for (int32_t k = 0; k < block.cells.z; ++k) {
    for (int32_t j = 0; j < block.cells.y; ++j) {
      const QuantizedValue* v =
          block.voxels.data() + static_cast<size_t>(k) * slice + static_cast<size_t>(j) * row;
      for (int32_t i = 0; i < block.cells.x; ++i, ++v, ++interval) {
        const auto [low, high] = std::minmax({v[0], v[1], v[row], v[row + 1], v[slice],
                                              v[slice + 1], v[slice + row], v[slice + row + 1]});
        const bool is_active = interval->min <= isovalue && isovalue < interval->max;
        if (!is_active && !(low <= isovalue && isovalue < high)) {
          *interval = {low, low};
          continue;
        }
        if (!is_active) *interval = {low, high};
        interval->min = static_cast<QuantizedValue>(std::min(interval->min, low) & ~kLow);
        interval->max = static_cast<QuantizedValue>(std::max(interval->max, high) | kLow);
      }
    }
  }
}

}  // namespace isosplat
