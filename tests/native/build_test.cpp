#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/survey.h"
#include "shared/core/builder/metadata.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/preprocess/quantization.h"
#include "tests/native/brute_force.h"

namespace isosplat {
namespace {

VolumeGrid grid_of(Index3 voxels) {
  VolumeGrid grid;
  grid.voxels = voxels;
  return grid;
}

size_t voxel_count(Index3 n) {
  return static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * static_cast<size_t>(n.z);
}

/// A field that is smooth with some noise and some constant regions, scaled to the type's range.
template <class T>
std::vector<T> random_volume(Index3 n, uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double a, double b) {
    return a + (b - a) * static_cast<double>(random()) / 4294967295.0;
  };
  const double fx = uniform(0.02, 0.3), fy = uniform(0.02, 0.3), fz = uniform(0.02, 0.3);
  const double noise = seed % 3 == 0 ? 0 : uniform(0, 0.1);
  double low = 0, high = 1;
  if constexpr (std::is_integral_v<T>) {
    low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
    if (sizeof(T) == 4 && seed % 2 == 0) low = -3000 * std::is_signed_v<T>, high = 50000;
  } else {
    low = -12.5, high = 900;
  }
  std::vector<T> voxels(voxel_count(n));
  size_t i = 0;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x, ++i) {
        double v = 0.5 + 0.4 * std::sin(fx * x) * std::cos(fy * y) * std::sin(fz * z + 0.5);
        v += noise * uniform(-1, 1);
        if (v < 0.35) v = 0.35;
        v = std::clamp(v, 0.0, 1.0);
        voxels[i] = static_cast<T>(low + v * (high - low));
      }
    }
  }
  return voxels;
}

template <class T>
void compare_with_brute_force(Index3 n, const std::vector<T>& voxels, const BuildOptions& options) {
  const auto store = build_store_bytes<T>(grid_of(n), voxels, options);
  ASSERT_TRUE(store) << store.error().message;
  expect_store_of<T>(*store, n, voxels);
}

template <class T>
class BuildOfType : public testing::Test {};
using VoxelTypes = testing::Types<uint8_t, int8_t, uint16_t, int16_t, uint32_t, int32_t, uint64_t,
                                  int64_t, float, double>;
TYPED_TEST_SUITE(BuildOfType, VoxelTypes);

TYPED_TEST(BuildOfType, YieldsTheActiveCellsAtEveryLevel) {
  uint32_t seed = 1;
  for (const Index3 n : {Index3{2, 2, 2}, Index3{3, 2, 5}, Index3{65, 64, 63}, Index3{66, 65, 67},
                         Index3{130, 3, 70}, Index3{2, 200, 2}, Index3{40, 40, 40}}) {
    SCOPED_TRACE(testing::Message() << n.x << " x " << n.y << " x " << n.z);
    compare_with_brute_force(n, random_volume<TypeParam>(n, seed++), {});
  }
}

TYPED_TEST(BuildOfType, NoiseYieldsItsActiveCells) {
  const Index3 n{67, 34, 66};
  std::mt19937 random(5);
  std::vector<TypeParam> voxels(voxel_count(n));
  for (auto& v : voxels) v = static_cast<TypeParam>(random() % 4294967291u);
  compare_with_brute_force(n, voxels, {});
}

TYPED_TEST(BuildOfType, AConstantVolumeHasNoChunk) {
  const Index3 n{70, 20, 10};
  const std::vector<TypeParam> voxels(voxel_count(n), TypeParam{7});
  const auto store = build_store_bytes<TypeParam>(grid_of(n), voxels);
  ASSERT_TRUE(store) << store.error().message;
  const auto reader = StoreReader::open(*store);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().chunk_count, 0u);
  expect_store_of<TypeParam>(*store, n, voxels);
}

TYPED_TEST(BuildOfType, FlatVolumesHaveNoCells) {
  for (const Index3 n : {Index3{1, 20, 30}, Index3{20, 1, 30}, Index3{20, 30, 1}}) {
    const std::vector<TypeParam> voxels(voxel_count(n));
    const auto store = build_store_bytes<TypeParam>(grid_of(n), voxels);
    ASSERT_FALSE(store);
    EXPECT_EQ(store.error().status, Status::no_cells);
  }
}

TEST(Build, CellsWithMissingVoxelsAreInactive) {
  for (const Index3 n : {Index3{50, 40, 30}, Index3{67, 66, 5}}) {
    auto voxels = random_volume<float>(n, 3);
    std::mt19937 random(4);
    const float odd[] = {std::nanf(""), std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity()};
    uint64_t missing = 0;
    for (size_t i = 0; i < voxels.size(); ++i) {
      const bool in_hole = i % 50 < 13 && i / 50 % 40 < 9;
      if (random() % 97 == 0 || in_hole) {
        voxels[i] = odd[random() % 3];
        ++missing;
      }
    }
    const auto store = build_store_bytes<float>(grid_of(n), voxels);
    ASSERT_TRUE(store);
    EXPECT_EQ(StoreReader::open(*store)->info().missing_voxels, missing);
    expect_store_of<float>(*store, n, voxels);
  }
}

TEST(Build, AVolumeWithoutAnyValueHasNoChunk) {
  const std::vector<double> voxels(1000, std::nan(""));
  const auto store = build_store_bytes<double>(grid_of({10, 10, 10}), voxels);
  ASSERT_TRUE(store) << store.error().message;
  const auto reader = StoreReader::open(*store);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().missing_voxels, 1000u);
  EXPECT_EQ(reader->info().chunk_count, 0u);
}

TEST(Build, DoublesOfAnyMagnitudeAreQuantizedWithinTheBound) {
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{
           {-1e300, 1e300}, {1e-300, 2e-300}, {-5, -4.999}, {0, 5e-324}, {1e15, 1e15 + 3}}) {
    std::vector<double> voxels(8 * 9 * 10);
    std::mt19937 random(1);
    for (double& v : voxels) {
      const double share = static_cast<double>(random()) / 4294967295.0;
      v = low * (1 - share) + high * share;
    }
    voxels[0] = low, voxels[1] = high;
    VoxelScan scan(VoxelType::f64);
    scan.add(std::as_bytes(std::span(voxels)));
    VolumeHeader header;
    header.type = VoxelType::f64;
    const auto quantization = choose_quantization(header, scan);
    ASSERT_TRUE(quantization) << quantization.error().message;
    const ValueMapping& mapping = quantization->mapping();
    std::vector<QuantizedValue> quantized_values(voxels.size());
    if (mapping.bits == 16) {
      quantization->encode(std::as_bytes(std::span(voxels)), quantized_values.data());
    } else {
      std::vector<uint8_t> narrow(voxels.size());
      quantization->encode(std::as_bytes(std::span(voxels)), narrow.data());
      std::copy(narrow.begin(), narrow.end(), quantized_values.begin());
    }
    for (size_t i = 0; i < voxels.size(); ++i) {
      EXPECT_LE(std::abs(mapping.value(quantized_values[i]) - voxels[i]),
                mapping.max_error * (1 + 1e-6))
          << low << " " << high;
    }
  }
}

TEST(Build, DoesNotDependOnThreadsAndMemory) {
  const Index3 n{150, 140, 200};
  const auto voxels = random_volume<uint16_t>(n, 2);
  BuildOptions options;
  options.threads = 1;
  const auto expected = build_store_bytes<uint16_t>(grid_of(n), voxels, options);
  ASSERT_TRUE(expected);
  for (const unsigned threads : {2u, 3u, 8u}) {
    options.threads = threads;
    ArraySource<uint16_t> source(grid_of(n), voxels);
    for (const uint64_t memory : {min_memory(source, options), uint64_t{1} << 32}) {
      options.memory_bytes = memory;
      MemorySink sink;
      const auto report = build_store(source, sink, options);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_EQ(report->uses_temporary_files, memory != uint64_t{1} << 32);
      EXPECT_TRUE(sink.bytes == *expected);
    }
  }
}

TEST(Survey, AgreesWithTheMetadataOfTheBuild) {
  const Index3 n{70, 80, 150};
  auto voxels = random_volume<float>(n, 2);
  voxels[5000] = std::nanf("");
  const auto store = build_store_bytes<float>(grid_of(n), voxels);
  ASSERT_TRUE(store) << store.error().message;
  const auto metadata = nlohmann::json::parse(StoreReader::open(*store)->info().metadata);
  ArraySource<float> source(grid_of(n), voxels);
  for (const size_t layer_bytes : {size_t{256} << 20, size_t{1}}) {
    const auto survey = survey_volume(source, layer_bytes);
    ASSERT_TRUE(survey) << survey.error().message;
    EXPECT_EQ(survey->missing, 1u);
    const auto histogram = value_histogram(survey->mapping, survey->statistics);
    EXPECT_EQ(metadata["histogram"]["low"], histogram.low);
    EXPECT_EQ(metadata["histogram"]["counts"], histogram.counts);
    const auto suggested = suggested_isovalues(survey->mapping, survey->statistics);
    EXPECT_FALSE(suggested.empty());
    // With layer_bytes 1, the survey reads thin layers, so it samples cells other than those of the
    // build.
    if (layer_bytes > 1) {
      EXPECT_EQ(metadata["suggested_isovalues"], suggested);
    }
  }
}

TEST(Build, TooLittleMemoryIsReportedBeforeTheStart) {
  const std::vector<float> voxels(50 * 50 * 50);
  ArraySource<float> source(grid_of({50, 50, 50}), voxels);
  BuildOptions options;
  options.memory_bytes = min_memory(source, options) - 1;
  MemorySink sink;
  const auto report = build_store(source, sink, options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().status, Status::out_of_memory);
  EXPECT_NE(report.error().message.find("--memory"), std::string::npos);
  EXPECT_TRUE(sink.bytes.empty());
}

}  // namespace
}  // namespace isosplat
