// The steps from voxels to blocks, compared with brute force: natively and as WebAssembly.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "shared/core/preprocess/coarsen.h"
#include "shared/core/preprocess/quantization.h"
#include "shared/core/preprocess/round_intervals.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {
namespace {

/// Level 0 of a volume of noise whose last blocks are not full.
class Noise : public ::testing::TestWithParam<uint8_t> {
 protected:
  Noise() : quantized_values_(size_t{75} * 70 * 68) {
    std::mt19937 random(GetParam());
    const uint32_t most = GetParam() == 8 ? 255 : 4095;
    for (uint16_t& quantized : quantized_values_)
      quantized = static_cast<uint16_t>(random() % (most + 1));
    bytes_.assign(quantized_values_.begin(), quantized_values_.end());
    layer_.grid = level_grid(kVoxels, 0);
    layer_.bits = GetParam();
    layer_.voxels = GetParam() == 8 ? reinterpret_cast<const std::byte*>(bytes_.data())
                                    : reinterpret_cast<const std::byte*>(quantized_values_.data());
    layer_.voxel_box = voxel_slices(layer_.grid, 0, kVoxels.z);
  }

  static constexpr Index3 kVoxels{75, 70, 68};

  uint16_t at(Index3 voxel) const {
    return quantized_values_[static_cast<size_t>((voxel.z * 70 + voxel.y) * 75 + voxel.x)];
  }

  CellInterval interval_at(Index3 cell) const {
    CellInterval interval{65535, 0};
    for (int32_t k = 0; k < 8; ++k) {
      const uint16_t quantized = at({cell.x + (k & 1), cell.y + (k >> 1 & 1), cell.z + (k >> 2)});
      interval.min = std::min(interval.min, quantized);
      interval.max = std::max(interval.max, quantized);
    }
    return interval;
  }

  std::vector<uint16_t> quantized_values_;
  std::vector<uint8_t> bytes_;
  Layer layer_;
};

TEST_P(Noise, BlocksHaveTheirVoxelsAndTheIntervalsOfTheirCells) {
  GatheredBlock block;
  uint64_t cells = 0, wrong = 0;
  for (int32_t b = 0; b < 8; ++b) {
    const Index3 index{b & 1, b >> 1 & 1, b >> 2};
    gather_block(layer_, index, block);
    EXPECT_EQ(block.cells, block_cells(layer_.grid, index));
    size_t i = 0;
    for (int32_t z = 0; z < block.cells.z; ++z) {
      for (int32_t y = 0; y < block.cells.y; ++y) {
        for (int32_t x = 0; x < block.cells.x; ++x, ++i) {
          const Index3 cell{index.x * kBlockCells + x, index.y * kBlockCells + y,
                            index.z * kBlockCells + z};
          const CellInterval expected = interval_at(cell);
          const auto corner =
              static_cast<size_t>((z * (block.cells.y + 1) + y) * (block.cells.x + 1) + x);
          wrong += !(block.intervals[i] == expected) || block.voxels[corner] != at(cell);
          ++cells;
        }
      }
    }
  }
  EXPECT_EQ(cells, uint64_t{74} * 69 * 67);
  EXPECT_EQ(wrong, 0u);
}

TEST_P(Noise, ACoarserLevelAveragesVoxelsAndUnitesIntervals) {
  const LevelGrid grid = level_grid(kVoxels, 1);
  const size_t value_bytes = GetParam() / 8;
  const LevelBox voxel_box = voxel_slices(grid, 0, grid.cells.z + 1);
  const LevelBox cell_box = cell_slices(grid, 0, grid.cells.z);
  std::vector<std::byte> voxels(voxel_box.count() * value_bytes);
  std::vector<std::byte> intervals(cell_box.count() * 2 * value_bytes);
  const CoarserLayer coarser{grid, voxels.data(), voxel_box, intervals.data(), cell_box};
  GatheredBlock block;
  for (int32_t b = 0; b < 8; ++b) {
    gather_block(layer_, {b & 1, b >> 1 & 1, b >> 2}, block);
    coarsen_block(layer_, block, coarser);
  }
  const auto value_at = [&](const std::vector<std::byte>& bytes, size_t i) {
    const std::byte* const quantized = bytes.data() + i * value_bytes;
    return value_bytes == 1
               ? static_cast<uint32_t>(quantized[0])
               : static_cast<uint32_t>(quantized[0]) | static_cast<uint32_t>(quantized[1]) << 8;
  };
  uint64_t wrong = 0;
  size_t i = 0;
  for (int32_t z = 0; z <= grid.cells.z; ++z) {
    for (int32_t y = 0; y <= grid.cells.y; ++y) {
      for (int32_t x = 0; x <= grid.cells.x; ++x, ++i) {
        const Index3 centre{std::min(2 * x, 74), std::min(2 * y, 69), std::min(2 * z, 67)};
        uint32_t sum = 0;
        for (int32_t k = 0; k < 27; ++k) {
          const int32_t dx = k % 3 - 1, dy = k / 3 % 3 - 1, dz = k / 9 - 1;
          const uint32_t weight = uint32_t{8} >> (std::abs(dx) + std::abs(dy) + std::abs(dz));
          sum += weight * at({std::clamp(centre.x + dx, 0, 74), std::clamp(centre.y + dy, 0, 69),
                              std::clamp(centre.z + dz, 0, 67)});
        }
        wrong += value_at(voxels, i) != (sum + 32) / 64;
      }
    }
  }
  EXPECT_EQ(wrong, 0u) << "voxels";
  i = 0;
  for (int32_t z = 0; z < grid.cells.z; ++z) {
    for (int32_t y = 0; y < grid.cells.y; ++y) {
      for (int32_t x = 0; x < grid.cells.x; ++x, i += 2) {
        CellInterval united{65535, 0};
        for (int32_t k = 0; k < 8; ++k) {
          const Index3 cell{2 * x + (k & 1), 2 * y + (k >> 1 & 1), 2 * z + (k >> 2)};
          if (cell.x >= 74 || cell.y >= 69 || cell.z >= 67) continue;
          const CellInterval below = interval_at(cell);
          united.min = std::min(united.min, below.min);
          united.max = std::max(united.max, below.max);
        }
        wrong += value_at(intervals, i) != united.min || value_at(intervals, i + 1) != united.max;
      }
    }
  }
  EXPECT_EQ(wrong, 0u) << "intervals";
}

TEST_P(Noise, RoundedIntervalsContainTheOriginalOnes) {
  GatheredBlock block;
  gather_block(layer_, {0, 0, 0}, block);
  const std::vector<CellInterval> before = block.intervals;
  round_intervals(block);
  uint64_t narrower = 0, wider = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    narrower += block.intervals[i].min > before[i].min || block.intervals[i].max < before[i].max;
    wider += !(block.intervals[i] == before[i]);
  }
  EXPECT_EQ(narrower, 0u);
  EXPECT_GT(wider, before.size() / 2) << "noise has wide spans";
}

TEST_P(Noise, StatisticsCountEveryVoxel) {
  VolumeStatistics one, other;
  const size_t half = quantized_values_.size() / 2;
  one.add_values(layer_.voxels, half, GetParam(), false);
  other.add_values(layer_.voxels + half * GetParam() / 8, quantized_values_.size() - half,
                   GetParam(), false);
  one.add(other);
  const CellInterval range = one.range();
  EXPECT_EQ(range.min, *std::min_element(quantized_values_.begin(), quantized_values_.end()));
  EXPECT_EQ(range.max, *std::max_element(quantized_values_.begin(), quantized_values_.end()));
  const QuantizedBins bins = QuantizedBins::over(range, 100);
  std::vector<uint64_t> expected(bins.count);
  for (const uint16_t quantized : quantized_values_)
    ++expected[(quantized - bins.first) / bins.width];
  EXPECT_EQ(one.histogram(bins), expected);
}

INSTANTIATE_TEST_SUITE_P(Bits, Noise, ::testing::Values(uint8_t{8}, uint8_t{16}));

template <class T>
Quantization quantization_for(const std::vector<T>& voxels, VoxelType type, double slope,
                              double max_error) {
  VoxelScan scan(type);
  scan.add(std::as_bytes(std::span(voxels)));
  VolumeHeader header;
  header.type = type;
  header.slope = slope;
  auto quantized_values = choose_quantization(header, scan, max_error);
  EXPECT_TRUE(quantized_values) << quantized_values.error().message;
  return std::move(*quantized_values);
}

/// The values of voxels after they were quantized and restored.
template <class T>
std::vector<double> kept_values(const std::vector<T>& voxels,
                                const Quantization& quantized_values) {
  std::vector<uint16_t> wide(voxels.size());
  std::vector<uint8_t> narrow(voxels.size());
  const ValueMapping& mapping = quantized_values.mapping();
  const bool is_narrow = mapping.bits == 8;
  quantized_values.encode(std::as_bytes(std::span(voxels)),
                          is_narrow ? static_cast<void*>(narrow.data()) : wide.data());
  std::vector<double> values;
  for (size_t i = 0; i < voxels.size(); ++i) {
    values.push_back(mapping.value(is_narrow ? narrow[i] : wide[i]));
  }
  return values;
}

TEST(Quantization, KeepIntegersUnderANegativeSlope) {
  std::vector<int16_t> voxels;
  for (int32_t v = -1024; v <= 3071; ++v) voxels.push_back(static_cast<int16_t>(v));
  const Quantization quantized_values = quantization_for(voxels, VoxelType::i16, -0.25, 0);
  EXPECT_EQ(quantized_values.mapping().max_error, 0);
  const std::vector<double> values = kept_values(voxels, quantized_values);
  for (size_t i = 0; i < voxels.size(); ++i) EXPECT_EQ(values[i], -0.25 * voxels[i]);
}

TEST(Quantization, KeepFloatsThatAreMultiplesOfATenth) {
  std::vector<float> voxels;
  for (int32_t i = -500; i < 1500; ++i) voxels.push_back(static_cast<float>(i) / 10);
  const Quantization quantized_values = quantization_for(voxels, VoxelType::f32, 1, 0);
  const std::vector<double> values = kept_values(voxels, quantized_values);
  for (size_t i = 0; i < voxels.size(); ++i) EXPECT_EQ(static_cast<float>(values[i]), voxels[i]);
}

TEST(Quantization, StaysWithinTheRequestedError) {
  std::mt19937 random(5);
  std::vector<double> voxels;
  for (int32_t i = 0; i < 5000; ++i) voxels.push_back(std::sqrt(static_cast<double>(random())));
  const double most = 65536;  // the square root of 2³²
  const Quantization quantized_values = quantization_for(voxels, VoxelType::f64, 1, most / 400);
  EXPECT_EQ(quantized_values.mapping().bits, 8);
  EXPECT_LE(quantized_values.mapping().max_error, most / 400);
  const std::vector<double> values = kept_values(voxels, quantized_values);
  for (size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_NEAR(values[i], voxels[i], quantized_values.mapping().max_error * (1 + 1e-9));
  }
}

TEST(Quantization, AnErrorTooSmallForSixteenBitsIsRefusedWithTheSmallestPossible) {
  const std::vector<double> voxels{0, 0.1234567, 1e6};
  VoxelScan scan(VoxelType::f64);
  scan.add(std::as_bytes(std::span(voxels)));
  VolumeHeader header;
  header.type = VoxelType::f64;
  const auto quantized_values = choose_quantization(header, scan, 1e-3);
  ASSERT_FALSE(quantized_values);
  EXPECT_EQ(quantized_values.error().status, Status::invalid_argument);
  EXPECT_NE(quantized_values.error().message.find("0.001: expected at least 7.6"),
            std::string::npos)
      << quantized_values.error().message;
}

}  // namespace
}  // namespace isosplat
