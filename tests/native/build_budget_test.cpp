#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/isovalue_guess.h"
#include "native/builder/size_budget.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{193, 193, 193};

VolumeSample noisy_sample(unsigned threads = 2) {
  VolumeGrid grid;
  grid.voxels = kVoxels;
  std::mt19937 random(1);
  std::vector<uint8_t> voxels(size_t{193} * 193 * 193);
  for (uint8_t& voxel : voxels) voxel = static_cast<uint8_t>(100 + random() % 32);
  ArraySource<uint8_t> source(grid, voxels);
  const auto scan = scan_volume(source, threads, true, [](uint64_t) {});
  return *sample_volume(source, *choose_codes(source.header(), *scan), threads);
}

SizeForecast forecast_of(const VolumeSample& sample) {
  const std::vector<double> distribution = guess_isovalues(sample.statistics, sample.voxels);
  SlabOptions options;
  options.isovalue_distribution = distribution;
  options.lambda = 0.01;
  return {sample, kVoxels, options, 2};
}

TEST(VolumeSample, IsTheSameWhateverTheThreads) {
  const VolumeSample one = noisy_sample(1), many = noisy_sample(5);
  ASSERT_EQ(one.columns.size(), many.columns.size());
  EXPECT_EQ(one.voxels, size_t{24} * 193 * 193);
  EXPECT_EQ(one.voxels, many.voxels);
  for (size_t i = 0; i < one.columns.size(); ++i) {
    EXPECT_EQ(one.columns[i].bits, many.columns[i].bits);
    EXPECT_TRUE(one.columns[i].intervals == many.columns[i].intervals);
  }
  // Five bits of noise.
  EXPECT_NEAR(one.columns[0].bits, 5, 0.6);
}

TEST(SizeForecast, FallsWithLambdaAndAddsUp) {
  const SizeForecast forecast = forecast_of(noisy_sample());
  EXPECT_EQ(forecast.lambda(0), 0.01);
  EXPECT_NEAR(forecast.lambda(kDials - 1), kMostLambda, 1e-9);
  for (const bool coarse : {false, true}) {
    for (size_t dial = 1; dial < kDials; ++dial) {
      EXPECT_LE(forecast.all(coarse)[dial], forecast.all(coarse)[dial - 1]);
    }
  }
  EXPECT_LT(forecast.all(false).back(), 0.7 * forecast.all(false).front());
  double sum = 0;
  for (int32_t i = 0; i < 27; ++i) sum += forecast.block(0, {i % 3, i / 3 % 3, i / 9})[3];
  EXPECT_NEAR(sum, forecast.all(false)[3], 1e-6 * sum);
}

TEST(SizeBudget, TakesTheLeastLambdaWhereThereIsRoom) {
  const SizeForecast forecast = forecast_of(noisy_sample());
  const double all = forecast.all(false)[0] + forecast.all(true)[0];
  EXPECT_TRUE(SizeBudget(forecast, 4 * all, 0).is_ample());
  EXPECT_FALSE(SizeBudget(forecast, 2 * all, 0).is_ample());
  EXPECT_EQ(SizeBudget(forecast, 1.2 * all, 0).grant().lambda, 0.01);
  EXPECT_GT(SizeBudget(forecast, all, 0).grant().lambda, 0.01);
  EXPECT_GT(SizeBudget(forecast, 1.2 * all, 0.3 * all).grant().lambda, 0.01);
}

TEST(SizeBudget, TakesTheMostLambdaWhereNothingFits) {
  const SizeForecast forecast = forecast_of(noisy_sample());
  const SizeBudget::Grant grant = SizeBudget(forecast, 0.5 * forecast.all(false).back(), 0).grant();
  EXPECT_EQ(grant.lambda, forecast.lambda(kDials - 1));
  EXPECT_LT(grant.slack, 0);
}

TEST(SizeBudget, LearnsFromWhatBlocksTake) {
  const SizeForecast forecast = forecast_of(noisy_sample());
  const double most = 1.2 * (forecast.all(false)[4] + forecast.all(true)[4]);
  // Blocks that take as forecast, more, and less, with the λ that they were granted.
  const auto lambda_after = [&](double ratio) {
    SizeBudget budget(forecast, most, 0);
    for (int32_t x = 0; x < 3; ++x) {
      const double lambda = forecast.lambda(5);
      budget.add(0, {x, 0, 0}, lambda, ratio * forecast.block(0, {x, 0, 0})[5]);
    }
    return budget.grant();
  };
  EXPECT_GT(lambda_after(1.2).lambda, lambda_after(1.0).lambda);
  EXPECT_LT(lambda_after(0.8).lambda, lambda_after(1.0).lambda);
  EXPECT_GT(lambda_after(1.2).correction[0], 1.15);
  EXPECT_EQ(lambda_after(1.2).correction[1], 1);
  EXPECT_LT(lambda_after(1.2).slack, lambda_after(1.0).slack);
}

}  // namespace
}  // namespace isosplat
