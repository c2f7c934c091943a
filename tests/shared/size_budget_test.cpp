// Forecasts of a store's size, and the budget that follows them, for a volume of noise.

#include "shared/core/preprocess/size_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shared/core/preprocess/isovalue_guess.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{193, 193, 193};

/// Columns of four slices of cells through the middle of each of the 3×3×3 blocks.
VolumeSample noisy_sample() {
  std::mt19937 random(1);
  std::vector<uint8_t> quantized_values(size_t{193} * 193 * 5);
  VolumeSample sample;
  sample.columns_across = {3, 3, 3};
  GatheredBlock scratch;
  for (int32_t z = 0; z < 3; ++z) {
    for (uint8_t& quantized : quantized_values) quantized = static_cast<uint8_t>(random() % 32);
    sample.statistics.add_values(quantized_values.data(), quantized_values.size(), 8, false);
    sample.voxels += quantized_values.size();
    Layer layer;
    layer.grid = level_grid({193, 193, 5}, 0);
    layer.bits = 8;
    layer.voxels = reinterpret_cast<const std::byte*>(quantized_values.data());
    layer.voxel_box = voxel_slices(layer.grid, 0, 5);
    for (int32_t block = 0; block < 9; ++block) {
      sample.columns.push_back(sample_column(layer, {block % 3, block / 3, 0}, scratch));
    }
  }
  return sample;
}

SizeForecast noisy_forecast() {
  const VolumeSample sample = noisy_sample();
  const std::vector<double> distribution = guess_isovalues(sample.statistics, sample.voxels);
  BandOptions options;
  options.isovalue_distribution = distribution;
  options.storage_weight = 0.01;
  std::vector<ColumnForecast> columns;
  BandPlanner planner;
  for (const SampleColumn& column : sample.columns) {
    columns.push_back(forecast_column(column, options, planner));
  }
  return {sample, kVoxels, options, columns};
}

TEST(VolumeSample, EstimatesTheBitsOfNoise) {
  for (const SampleColumn& column : noisy_sample().columns) {
    EXPECT_EQ(column.cells, (Index3{64, 64, 4}));
    EXPECT_EQ(column.intervals.size(), size_t{64} * 64 * 4);
    EXPECT_NEAR(column.bits, 5, 0.6);
  }
}

TEST(SizeForecast, FallsWithTheStorageWeightAndAddsUp) {
  const SizeForecast forecast = noisy_forecast();
  EXPECT_EQ(forecast.storage_weight(0), 0.01);
  EXPECT_NEAR(forecast.storage_weight(kCandidateWeights - 1), kMaxStorageWeight, 1e-9);
  for (const bool coarse : {false, true}) {
    for (size_t candidate = 1; candidate < kCandidateWeights; ++candidate) {
      EXPECT_LE(forecast.all(coarse)[candidate], forecast.all(coarse)[candidate - 1]);
    }
  }
  EXPECT_LT(forecast.all(false).back(), 0.7 * forecast.all(false).front());
  double sum = 0;
  for (int32_t i = 0; i < 27; ++i) sum += forecast.block(0, {i % 3, i / 3 % 3, i / 9})[3];
  EXPECT_NEAR(sum, forecast.all(false)[3], 1e-6 * sum);
}

TEST(SizeBudget, ChoosesTheLeastStorageWeightIfTheStoreFits) {
  const SizeForecast forecast = noisy_forecast();
  const double all = forecast.all(false)[0] + forecast.all(true)[0];
  EXPECT_TRUE(SizeBudget(forecast, 4 * all, 0).is_ample());
  EXPECT_FALSE(SizeBudget(forecast, 2 * all, 0).is_ample());
  EXPECT_EQ(SizeBudget(forecast, 1.2 * all, 0).grant().storage_weight, 0.01);
  EXPECT_GT(SizeBudget(forecast, all, 0).grant().storage_weight, 0.01);
  EXPECT_GT(SizeBudget(forecast, 1.2 * all, 0.3 * all).grant().storage_weight, 0.01);
}

TEST(SizeBudget, ChoosesTheGreatestStorageWeightIfNothingFits) {
  const SizeForecast forecast = noisy_forecast();
  const SizeBudget::Grant grant = SizeBudget(forecast, 0.5 * forecast.all(false).back(), 0).grant();
  EXPECT_EQ(grant.storage_weight, forecast.storage_weight(kCandidateWeights - 1));
  EXPECT_LT(grant.slack, 0);
}

TEST(SizeBudget, AdaptsToTheSizesOfWrittenBlocks) {
  const SizeForecast forecast = noisy_forecast();
  const double most = 1.2 * (forecast.all(false)[4] + forecast.all(true)[4]);
  // Blocks that take the forecast number of bytes, more, and fewer, at the λ that they were given.
  const auto storage_weight_after = [&](double ratio) {
    SizeBudget budget(forecast, most, 0);
    for (int32_t x = 0; x < 3; ++x) {
      const double storage_weight = forecast.storage_weight(5);
      budget.add(0, {x, 0, 0}, storage_weight, ratio * forecast.block(0, {x, 0, 0})[5]);
    }
    return budget.grant();
  };
  EXPECT_GT(storage_weight_after(1.2).storage_weight, storage_weight_after(1.0).storage_weight);
  EXPECT_LT(storage_weight_after(0.8).storage_weight, storage_weight_after(1.0).storage_weight);
  EXPECT_GT(storage_weight_after(1.2).correction[0], 1.15);
  EXPECT_EQ(storage_weight_after(1.2).correction[1], 1);
  EXPECT_LT(storage_weight_after(1.2).slack, storage_weight_after(1.0).slack);
}

}  // namespace
}  // namespace isosplat
