#include "shared/core/preprocess/size_forecast.h"

#include <algorithm>

#include "shared/core/base/portable_math.h"
#include "shared/core/preprocess/block_storage_weight.h"

namespace isosplat {
namespace {

/// The bytes of a chunk grow with its number of cells to this power: a chunk with few cells of its
/// block has more points per cell, and they are predicted worse. Measured on eleven volumes: a
/// chunk with 1/200 of the cells takes up to 2.4 times as many bytes per cell as one with half of
/// them.
constexpr double kDensityPower = 0.8;

/// Bytes of a chunk that do not depend on its cells: header, coder states, and directory entry.
constexpr double kChunkBytes = 72;

/// Cells of coarse levels take about this times the bytes of cells of level 0, because of their
/// intervals.
constexpr double kCoarseCell = 1.8;

/// A block has more bands than a sample of a few of its slices, in which values vary less.
/// Measured: 1.05 to 1.4 times the bytes.
constexpr double kThinness = 1.18;

/// Points on the faces of a block are stored in each block that they touch.
constexpr double kSharedPoints = 1.047;

/// How many positions of cuts are tried; enough for a forecast.
constexpr uint32_t kCandidates = 32;

/// The cell intervals of the next coarser level.
std::vector<CellInterval> unite(const SampleColumn& column, Index3 coarse) {
  std::vector<CellInterval> united(
      static_cast<size_t>(coarse.x) * static_cast<size_t>(coarse.y) * static_cast<size_t>(coarse.z),
      CellInterval{65535, 0});
  const CellInterval* from = column.intervals.data();
  for (int32_t z = 0; z < column.cells.z; ++z) {
    for (int32_t y = 0; y < column.cells.y; ++y) {
      CellInterval* to =
          &united[static_cast<size_t>((z / 2) * coarse.y + y / 2) * static_cast<size_t>(coarse.x)];
      for (int32_t x = 0; x < column.cells.x; ++x, ++from) {
        CellInterval& interval = to[x / 2];
        interval.min = std::min(interval.min, from->min);
        interval.max = std::max(interval.max, from->max);
      }
    }
  }
  return united;
}

/// Forecasts the bytes per cell of a block that resembles these cells. cell_bytes: of each cell in
/// a chunk with all cells.
PerCandidate plan(BandPlanner& planner, const std::vector<CellInterval>& cells, double cell_bytes,
                  uint32_t level, BandOptions options, const PerCandidate& storage_weights) {
  constexpr double kBlock = double{kBlockCells} * kBlockCells * kBlockCells;
  const auto count = static_cast<double>(cells.size());
  planner.count(cells);
  options.max_candidates = kCandidates;
  options.overhead_cells *= count / kBlock;
  PerCandidate bytes{};
  for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate) {
    options.storage_weight = storage_weights[candidate];
    planner.plan(block_options(options, level, planner.cells(), cells.size()));
    for (const uint32_t band : planner.band_cells()) {
      if (band == 0) continue;
      bytes[candidate] +=
          cell_bytes * portable::pow(band / count, kDensityPower) + kChunkBytes / kBlock;
    }
    if (planner.band_cells().size() <= 1) {
      // The block is not cut, and will not be with a greater λ.
      std::fill(bytes.begin() + static_cast<ptrdiff_t>(candidate), bytes.end(), bytes[candidate]);
      break;
    }
  }
  return bytes;
}

/// Averages the columns that belong to one layer of blocks (they differ in z), and adds a part of
/// the mean of all columns, because a column may not be typical of its block.
void blend(std::vector<PerCandidate>& columns, int32_t layers_per_block) {
  constexpr double kOfMean = 0.15;
  const size_t count = columns.size() / static_cast<size_t>(layers_per_block);
  PerCandidate mean{};
  for (size_t i = 0; i < columns.size(); ++i) {
    for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate) {
      mean[candidate] += columns[i][candidate] / static_cast<double>(columns.size());
      if (i >= count) columns[i % count][candidate] += columns[i][candidate];
    }
  }
  columns.resize(count);
  for (PerCandidate& column : columns) {
    for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate) {
      column[candidate] =
          (1 - kOfMean) * column[candidate] / layers_per_block + kOfMean * mean[candidate];
    }
  }
}

}  // namespace

PerCandidate candidate_weights(double least) {
  PerCandidate storage_weights{};
  for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate) {
    storage_weights[candidate] =
        least * portable::pow(std::max(kMaxStorageWeight / least, 1.0),
                              static_cast<double>(candidate) / (kCandidateWeights - 1));
  }
  return storage_weights;
}

ColumnForecast forecast_column(const SampleColumn& column, const BandOptions& options,
                               BandPlanner& planner) {
  const PerCandidate storage_weights = candidate_weights(options.storage_weight);
  const double cell_bytes = column.bits / 8 * kSharedPoints * kThinness;
  const Index3 coarse{(column.cells.x + 1) / 2, (column.cells.y + 1) / 2, (column.cells.z + 1) / 2};
  return {
      plan(planner, column.intervals, cell_bytes, 0, options, storage_weights),
      plan(planner, unite(column, coarse), cell_bytes * kCoarseCell, 1, options, storage_weights)};
}

SizeForecast::SizeForecast(const VolumeSample& sample, Index3 voxels, const BandOptions& options,
                           std::span<const ColumnForecast> columns)
    : voxels_(voxels),
      across_(sample.columns_across),
      stride_(sample.stride),
      storage_weights_(candidate_weights(options.storage_weight)),
      all_{} {
  for (const ColumnForecast& column : columns) {
    per_cell_[0].push_back(column.finest);
    per_cell_[1].push_back(column.coarse);
  }
  for (auto& per_cell : per_cell_) blend(per_cell, sample.layers_per_block);
  across_.z /= sample.layers_per_block;
  for (uint32_t level = 0; level < level_count(voxels); ++level) {
    const Index3 blocks = level_grid(voxels, level).blocks;
    for (int32_t z = 0; z < blocks.z; ++z) {
      for (int32_t y = 0; y < blocks.y; ++y) {
        for (int32_t x = 0; x < blocks.x; ++x) {
          const PerCandidate bytes = block(level, {x, y, z});
          for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate)
            all_[level > 0][candidate] += bytes[candidate];
        }
      }
    }
  }
}

const PerCandidate& SizeForecast::column(uint32_t level, Index3 block) const {
  const Index3 blocks = level_grid(voxels_, 0).blocks;
  const int32_t x = std::min(block.x, blocks.x - 1) / stride_;
  const int32_t y = std::min(block.y, blocks.y - 1) / stride_;
  const auto z = static_cast<int32_t>((2 * int64_t{std::min(block.z, blocks.z - 1)} + 1) *
                                      across_.z / (2 * int64_t{blocks.z}));
  return per_cell_[level > 0][static_cast<size_t>((z * across_.y + y) * across_.x + x)];
}

PerCandidate SizeForecast::block(uint32_t level, Index3 index) const {
  const Index3 cells = block_cells(level_grid(voxels_, level), index);
  const double count = double{1} * cells.x * cells.y * cells.z;
  PerCandidate bytes{};
  const auto add = [&](Index3 finest_block, double weight) {
    const PerCandidate& per_cell = column(level, finest_block);
    for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate)
      bytes[candidate] += weight * per_cell[candidate];
  };
  if (level == 0) {
    add(index, count);
    return bytes;
  }
  // The average of eight blocks of level 0: those in the middles of the octants of this block.
  const int32_t wide = 1 << level;
  for (int32_t part = 0; part < 8; ++part) {
    const auto middle = [&](int32_t at, int32_t bit) {
      return at * wide + wide / 4 + (part >> bit & 1) * (wide / 2);
    };
    add({middle(index.x, 0), middle(index.y, 1), middle(index.z, 2)}, count / 8);
  }
  return bytes;
}

}  // namespace isosplat
