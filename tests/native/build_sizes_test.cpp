// The sizes of stores, and the bytes that an isovalue needs: for real volumes, and for generated
// volumes with noise of several strengths.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/builder.h"
#include "shared/import/open_volume.h"
#include "tests/native/brute_force.h"

namespace isosplat {
namespace {

/// A volume of the folder of real volumes; null if it does not exist.
std::unique_ptr<VolumeSource> real_volume(const std::string& name) {
  const char* chosen = std::getenv("ISOSPLAT_VOLUMES");
  const std::filesystem::path folder = chosen ? chosen : ISOSPLAT_SOURCE "/../shared/volumes";
  if (!std::filesystem::exists(folder / name)) return nullptr;
  auto volume = import::open_volume(folder / name, {});
  if (!volume) throw std::runtime_error(volume.error().message);
  return std::move(volume->source);
}

std::string test_name(const std::string& volume) {
  return volume.substr(0, volume.find('.'));
}

struct Expectation {
  std::string volume;
  double max_of_raw;   ///< size of the whole store relative to the voxels
  double isovalue;     ///< one isovalue of level 0
  uint64_t max_bytes;  ///< upper limit of the bytes that the isovalue needs
};

class BuildSizes : public testing::TestWithParam<Expectation> {};

TEST_P(BuildSizes, StayWithinTheirLimits) {
  const auto& [name, max_of_raw, isovalue, max_bytes] = GetParam();
  const auto volume = real_volume(name);
  if (!volume) GTEST_SKIP() << name << " is not in the folder of real volumes";
  MemorySink sink;
  const auto report = build_store(*volume, sink, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LE(static_cast<double>(sink.bytes.size()),
            max_of_raw * static_cast<double>(report->raw_bytes));
  const StoreReader reader = open_whole(sink.bytes);
  const float quantized_isovalue = reader.info().mapping.quantized_isovalue(isovalue);
  uint64_t bytes = 0;
  const auto chunks = reader.chunks_for(0, quantized_isovalue, quantized_isovalue);
  for (const ChunkRef& chunk : *chunks) bytes += chunk.bytes;
  EXPECT_LE(bytes, max_bytes);
}

INSTANTIATE_TEST_SUITE_P(Volumes, BuildSizes,
                         testing::Values(Expectation{"engine.nhdr", 0.70, 60.5, 430'000},
                                         Expectation{"bonsai.nhdr", 0.85, 100.5, 430'000},
                                         Expectation{"aneurysm.nhdr", 0.85, 100.5, 190'000},
                                         Expectation{"bunny_ct_i16.nrrd", 0.52, 1000.5, 4'800'000},
                                         Expectation{"lobster.nhdr", 0.85, 60.5, 262'000},
                                         Expectation{"statueLeg.nhdr", 0.85, 60.5, 219'000}),
                         [](const auto& test) { return test_name(test.param.volume); });

class BuildDefault : public testing::TestWithParam<std::string> {};

TEST_P(BuildDefault, TakesNoMoreThanTheVolume) {
  const auto volume = real_volume(GetParam());
  if (!volume) GTEST_SKIP() << GetParam() << " is not in the folder of real volumes";
  MemorySink sink;
  const auto report = build_store(*volume, sink, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LE(report->max_bytes, report->raw_bytes);
  EXPECT_LE(sink.bytes.size(), report->max_bytes);
}

INSTANTIATE_TEST_SUITE_P(Volumes, BuildDefault,
                         testing::Values("chris_t1.nii.gz", "CT_AVM.nii.gz", "ct_shear.nii.gz",
                                         "eun_brain.nii.gz", "mni152.nii.gz", "cthead_tif",
                                         "BostonTeapot.nhdr", "hydrogenAtom.nhdr", "fuel.nhdr",
                                         "shockwave.nhdr", "neghip.nhdr", "nucleon.nhdr",
                                         "marschnerlobb.nhdr", "iron_protein.vtk"),
                         [](const auto& test) { return test_name(test.param); });

/// A ball with inner structure, surrounded by air. Values are 0 to 1.
double scene(int32_t x, int32_t y, int32_t z, Index3 n) {
  const double u = 2.0 * x / n.x - 1, v = 2.0 * y / n.y - 1, w = 2.0 * z / n.z - 1;
  const double r = std::sqrt(u * u + v * v + w * w);
  if (r > 0.9) return 0;
  return 0.4 + 0.2 * std::sin(5 * u + 2 * v) * std::cos(4 * v - w) + (r < 0.6 ? 0.3 : 0);
}

/// Tubes that wind through the air.
double vessels(int32_t x, int32_t y, int32_t z, Index3 n) {
  const double u = 6.3 * x / n.x, v = 6.3 * y / n.y, w = 6.3 * z / n.z;
  const double a = std::sin(u) + std::cos(v + w), b = std::sin(v) + std::cos(w - u);
  return a * a + b * b < 0.01 ? 0.8 : 0;
}

/// Random numbers, approximately normally distributed with variance 1, and the same on every
/// machine.
class Noise {
 public:
  double next() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random_()) / 4294967296.0;
    return sum;
  }

 private:
  std::mt19937 random_{7};
};

template <class T, class F>
std::vector<T> generate(Index3 n, F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const double most = static_cast<double>(std::numeric_limits<T>::max());
        voxels.push_back(
            static_cast<T>(std::clamp(static_cast<double>(value(x, y, z)), 0.0, most)));
      }
    }
  }
  return voxels;
}

struct Built {
  std::vector<std::byte> store;
  BuildReport report;
};

template <class T>
Built build(Index3 n, const std::vector<T>& voxels, const BuildOptions& options = {}) {
  VolumeGrid grid;
  grid.voxels = n;
  ArraySource<T> source(grid, voxels);
  MemorySink sink;
  auto report = build_store(source, sink, options);
  if (!report) throw std::runtime_error(report.error().message);
  return {std::move(sink.bytes), std::move(*report)};
}

/// Bytes of the chunks of all levels that an isovalue needs, on average over the store's range.
double isovalue_bytes(const std::vector<std::byte>& store) {
  const StoreReader reader = open_whole(store);
  double sum = 0;
  for (const LevelRef& level : reader.levels()) {
    const auto chunks = reader.chunks_for(level.grid.level, 0, 65535);
    for (const ChunkRef& chunk : *chunks) {
      sum += double{1} * chunk.bytes * (chunk.band_end - chunk.band_begin);
    }
  }
  return sum / (reader.info().range.max - reader.info().range.min);
}

TEST(BuildSize, OfANoisyVolumeIsAtMostThatOfItsVoxels) {
  for (const Index3 n : {Index3{130, 110, 140}, Index3{64, 65, 60}, Index3{200, 180, 30}}) {
    for (const double noise : {0.0, 0.01, 0.03, 0.055}) {
      SCOPED_TRACE(testing::Message() << n.x << "x" << n.y << "x" << n.z << ", noise " << noise);
      Noise random;
      const auto byte = generate<uint8_t>(n, [&](int32_t x, int32_t y, int32_t z) {
        return 20 + 220 * scene(x, y, z, n) + 255 * noise * random.next();
      });
      const Built eight = build(n, byte);
      EXPECT_EQ(eight.report.max_bytes, byte.size());
      EXPECT_LE(eight.store.size(), byte.size());
      const auto word = generate<uint16_t>(n, [&](int32_t x, int32_t y, int32_t z) {
        return 300 + 3400 * scene(x, y, z, n) + 4095 * noise * random.next();
      });
      EXPECT_LE(build(n, word).store.size(), 2 * word.size());
      // Like magnitude images of magnetic resonance, in which the air has noise, too.
      const auto rician = generate<uint8_t>(n, [&](int32_t x, int32_t y, int32_t z) {
        return std::hypot(230 * scene(x, y, z, n) + 255 * noise * random.next(),
                          255 * noise * random.next());
      });
      EXPECT_LE(build(n, rician).store.size(), rician.size());
      const auto sparse = generate<uint8_t>(n, [&](int32_t x, int32_t y, int32_t z) {
        return std::abs(230 * vessels(x, y, z, n) + 255 * noise * random.next());
      });
      EXPECT_LE(build(n, sparse).store.size(), sparse.size());
    }
  }
}

TEST(BuildSize, IsAtMostThatOfTheVoxelsWhereverTheNoiseIs) {
  const Index3 n{130, 130, 150};
  for (const int32_t from : {0, 50, 100}) {
    std::mt19937 random(3);
    const auto voxels = generate<uint8_t>(n, [&](int32_t, int32_t, int32_t z) {
      return z >= from && z < from + 50 ? random() % 256 : 20;
    });
    EXPECT_LE(build(n, voxels).store.size(), voxels.size()) << "noise from slice " << from << " on";
  }
}

TEST(BuildSize, OfPureNoiseIsMinimalAndNoted) {
  const Index3 n{100, 130, 90};
  std::mt19937 random(3);
  const auto voxels =
      generate<uint8_t>(n, [&](int32_t, int32_t, int32_t) { return random() % 256; });
  const Built built = build(n, voxels);
  EXPECT_EQ(built.report.max_bytes, voxels.size());
  EXPECT_GT(built.store.size(), voxels.size());
  EXPECT_LT(static_cast<double>(built.store.size()), 1.4 * static_cast<double>(voxels.size()));
  const StoreReader reader = open_whole(built.store);
  for (const LevelRef& level : reader.levels()) {
    EXPECT_EQ(level.chunk_count, level.grid.block_count()) << "level " << level.grid.level;
  }
}

TEST(BuildSize, GrowsWithTheFetchWeightWhileIsovaluesGetCheaper) {
  const Index3 n{130, 110, 140};
  for (const double noise : {0.0, 0.02}) {
    Noise random;
    const auto voxels = generate<uint8_t>(n, [&](int32_t x, int32_t y, int32_t z) {
      return 20 + 220 * scene(x, y, z, n) + 255 * noise * random.next();
    });
    double store = 0, isovalue = 1e300;
    for (const double weight : {0.5, 1.0, 2.0, 4.0, 8.0}) {
      BuildOptions options;
      options.fetch_weight = weight;
      const Built built = build(n, voxels, options);
      const auto bytes = static_cast<double>(built.store.size());
      EXPECT_GT(bytes, store) << weight;
      EXPECT_LT(isovalue_bytes(built.store), isovalue) << weight;
      EXPECT_NEAR(static_cast<double>(built.report.max_bytes),
                  static_cast<double>(voxels.size()) * std::sqrt(weight), 1);
      store = bytes;
      isovalue = isovalue_bytes(built.store);
    }
  }
}

TEST(BuildSize, DoesNotDependOnThreadsAndMemory) {
  const Index3 n{200, 180, 150};
  Noise random;
  const auto voxels = generate<uint8_t>(n, [&](int32_t x, int32_t y, int32_t z) {
    return 20 + 220 * scene(x, y, z, n) + 8 * random.next();
  });
  VolumeGrid grid;
  grid.voxels = n;
  ArraySource<uint8_t> source(grid, voxels);
  BuildOptions options;
  options.threads = 1;
  const std::vector<std::byte> expected = build(n, voxels, options).store;
  for (const unsigned threads : {2u, 3u, 7u, 16u}) {
    options.threads = threads;
    for (const uint64_t memory : {min_memory(source, options), uint64_t{1} << 32}) {
      options.memory_bytes = memory;
      EXPECT_TRUE(build(n, voxels, options).store == expected) << threads;
    }
  }
}

}  // namespace
}  // namespace isosplat
