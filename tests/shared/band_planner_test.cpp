#include "shared/core/bands/band_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isosplat {
namespace {

std::vector<CellInterval> random_cells(uint32_t seed, uint32_t count, uint32_t quantized_values) {
  std::mt19937 random(seed);
  std::vector<CellInterval> cells;
  for (uint32_t i = 0; i < count; ++i) {
    const auto a = static_cast<QuantizedValue>(100 + random() % quantized_values);
    const auto b = static_cast<QuantizedValue>(100 + random() % quantized_values);
    cells.push_back({std::min(a, b), std::max(a, b)});
    if (random() % 16 == 0) cells.back() = {65535, 0};
  }
  return cells;
}

double cost_of(const std::vector<CellInterval>& cells, const BandOptions& options, uint32_t begin,
               const std::vector<uint32_t>& ends) {
  double cost = 0;
  for (const uint32_t end : ends) {
    double count = 0;
    for (const CellInterval cell : cells) {
      count += std::max<uint32_t>(cell.min, begin) < std::min<uint32_t>(cell.max, end);
    }
    cost += ((end - begin) / 65536.0 + options.storage_weight) * count +
            (count > 0 ? options.storage_weight * options.overhead_cells : 0);
    begin = end;
  }
  return cost;
}

TEST(BandPlanner, FindsTheCheapestOfAllCuts) {
  for (uint32_t seed = 0; seed < 40; ++seed) {
    const auto cells = random_cells(seed, 5 + seed * 8, 10);
    BandOptions options;
    options.storage_weight = 0.000003 * (1 + seed % 5);
    options.overhead_cells = seed % 3 * 5;
    BandPlanner planner;
    planner.count(cells);
    const auto ends = planner.plan(options);
    const CellInterval range = planner.interval();
    ASSERT_FALSE(ends.empty());
    EXPECT_EQ(ends.back(), range.max);
    double best = 1e30;
    const uint32_t inner = static_cast<uint32_t>(range.max - range.min) - 1;
    for (uint32_t cuts = 0; cuts < 1u << inner; ++cuts) {
      std::vector<uint32_t> chosen;
      for (uint32_t i = 0; i < inner; ++i) {
        if (cuts >> i & 1) chosen.push_back(range.min + 1 + i);
      }
      chosen.push_back(range.max);
      best = std::min(best, cost_of(cells, options, range.min, chosen));
    }
    EXPECT_NEAR(cost_of(cells, options, range.min, ends), best, 1e-9 * best);
  }
}

TEST(BandPlanner, EndsAscendWithinTheInterval) {
  BandPlanner planner;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    for (const uint32_t quantized_values : {2u, 40u, 300u, 5000u, 65000u}) {
      const auto cells = random_cells(seed, 3000, quantized_values);
      planner.count(cells);
      BandOptions options;
      options.storage_weight = 0.001 * seed;
      uint32_t begin = planner.interval().min;
      for (const uint32_t end : planner.plan(options)) {
        EXPECT_GT(end, begin);
        begin = end;
      }
      EXPECT_EQ(begin, planner.interval().max);
    }
  }
}

TEST(BandPlanner, NoActiveCellsMeanNoBand) {
  BandPlanner planner;
  planner.count(random_cells(1, 100, 50));
  const std::vector<CellInterval> still = {{5, 5}, {65535, 0}, {9, 9}};
  planner.count(still);
  EXPECT_EQ(planner.cells(), 0u);
  EXPECT_EQ(planner.interval(), CellInterval{});
  EXPECT_TRUE(planner.plan({}).empty());
}

TEST(BandPlanner, MakesMoreCutsWhereIsovaluesAreLikely) {
  std::vector<CellInterval> cells;
  for (uint32_t i = 0; i < 20000; ++i) {
    const auto v = static_cast<QuantizedValue>(i % 200);
    cells.push_back({v, static_cast<QuantizedValue>(v + 2)});
  }
  std::vector<double> distribution(65537, 1.0);
  for (uint32_t quantized = 0; quantized < 100; ++quantized)
    distribution[quantized] = quantized / 100.0;
  BandPlanner planner;
  planner.count(cells);
  BandOptions options;
  options.isovalue_distribution = distribution;
  size_t low = 0, high = 0;
  for (const uint32_t end : planner.plan(options)) ++(end <= 100 ? low : high);
  EXPECT_GT(low, 2 * high);
}

}  // namespace
}  // namespace isosplat
