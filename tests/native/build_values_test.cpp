#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/survey.h"
#include "native/builder/verify.h"
#include "shared/core/preprocess/quantization.h"
#include "shared/import/open_volume.h"
#include "tests/native/brute_force.h"

// Compares stores with their volumes by values in the units of the file, never by quantized values.
namespace isosplat {
namespace {

constexpr Index3 kSize{37, 21, 30};

size_t voxel_count(Index3 n) {
  return static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * static_cast<size_t>(n.z);
}

/// Values that are smooth with some noise. They lie in [low, high], and both ends occur.
template <class T>
std::vector<T> integers(double low, double high, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<T> voxels;
  for (size_t i = 0; i < voxel_count(kSize); ++i) {
    const double x = static_cast<double>(i % 37), y = static_cast<double>(i / 37 % 21);
    const double noise = static_cast<double>(random() % 1000) / 1000 - 0.5;
    const double share = 0.5 + 0.45 * std::sin(0.3 * x) * std::cos(0.2 * y) + 0.1 * noise;
    voxels.push_back(static_cast<T>(std::round(low + std::clamp(share, 0.0, 1.0) * (high - low))));
  }
  voxels[11] = static_cast<T>(low);
  voxels[12345] = static_cast<T>(high);
  return voxels;
}

template <class T>
Result<std::vector<std::byte>> store_of(const std::vector<T>& voxels, double slope = 1,
                                        double intercept = 0, const BuildOptions& options = {}) {
  VolumeGrid grid;
  grid.voxels = kSize;
  ArraySource<T> source(grid, voxels, "values", slope, intercept);
  MemorySink sink;
  if (auto built = build_store(source, sink, options); !built) {
    return tl::unexpected(built.error());
  }
  return std::move(sink.bytes);
}

/// The cells of level 0 that a store yields for an isovalue, and the values of their corners.
struct FoundCells {
  std::vector<uint8_t> is_active;
  std::vector<double> corners;  ///< values of voxels; NaN if no active cell has the voxel
};

FoundCells find_cells(std::span<const std::byte> store, double isovalue) {
  const StoreReader reader = open_whole(store);
  const ValueMapping& mapping = reader.info().mapping;
  const float quantized_isovalue = mapping.quantized_isovalue(isovalue);
  FoundCells found;
  found.is_active.resize(voxel_count(kSize));
  found.corners.resize(voxel_count(kSize), std::nan(""));
  const LevelGrid grid = level_grid(kSize, 0);
  ChunkDecoder decoder;
  DecodedCells cells;
  const auto chunks = reader.chunks_for(0, quantized_isovalue, quantized_isovalue);
  for (const ChunkRef& chunk : *chunks) {
    const ChunkShape shape{block_cells(grid, chunk.block.index), chunk.band_begin, chunk.band_end,
                           chunk.cells, false};
    EXPECT_TRUE(decoder.decode(store.subspan(chunk.offset, chunk.bytes), shape, cells));
    for (size_t i = 0; i < cells.cell.size(); ++i) {
      if (!is_active(cells.interval[i], quantized_isovalue)) continue;
      const Index3 block = chunk.block.index * kBlockCells;
      const uint32_t c = cells.cell[i];
      const auto x = static_cast<size_t>(block.x) + (c & 63);
      const auto y = static_cast<size_t>(block.y) + (c >> 6 & 63);
      const auto z = static_cast<size_t>(block.z) + (c >> 12);
      found.is_active[(z * 21 + y) * 37 + x] = 1;
      for (size_t k = 0; k < 8; ++k) {
        found.corners[((z + (k >> 2)) * 21 + y + (k >> 1 & 1)) * 37 + x + (k & 1)] =
            mapping.value(cells.corners[i][k]);
      }
    }
  }
  return found;
}

/// Checks that the store yields exactly the cells with min ≤ isovalue < max. The isovalues are
/// equal to values, next to them, between them, and outside of their range. `values`: in the
/// precision of the file.
template <class Value>
void expect_active_cells(std::span<const std::byte> store, const std::vector<Value>& values) {
  std::set<Value> sorted(values.begin(), values.end());
  std::vector<Value> list(sorted.begin(), sorted.end());
  std::set<Value> isovalues;
  std::mt19937 random(3);
  for (int i = 0; i < 12; ++i) {
    const size_t at = i == 0 ? 0 : i == 1 ? list.size() - 1 : random() % list.size();
    // A nearby number. In single precision it is the next number, except near 0, where rounding
    // gives other numbers. In double precision it is the next number that differs in single
    // precision, if there is one between the values.
    const Value gap = at > 0 ? list[at] - list[at - 1] : list[1] - list[0];
    const Value near =
        std::is_same_v<Value, float>
            ? (std::abs(list[at]) < gap / 1000 ? gap / 1000 : Value(0))
            : std::min(std::max(std::abs(list[at]) * Value(2e-7), gap / 1000), gap / 4);
    const Value infinity = std::numeric_limits<Value>::infinity();
    isovalues.insert({list[at], std::nextafter(list[at] + near, infinity),
                      std::nextafter(list[at] - near, -infinity)});
    if (at > 0) isovalues.insert(list[at - 1] + (list[at] - list[at - 1]) / 2);
  }
  isovalues.insert({2 * list.front() - list[1], 2 * list.back() - list[list.size() - 2]});
  for (const Value isovalue : isovalues) {
    const FoundCells found = find_cells(store, static_cast<double>(isovalue));
    uint64_t wrong = 0;
    for (size_t z = 0; z < 29; ++z) {
      for (size_t y = 0; y < 20; ++y) {
        for (size_t x = 0; x < 36; ++x) {
          Value low = std::numeric_limits<Value>::infinity(), high = -low;
          for (size_t k = 0; k < 8; ++k) {
            const Value v = values[((z + (k >> 2)) * 21 + y + (k >> 1 & 1)) * 37 + x + (k & 1)];
            low = std::min(low, v), high = std::max(high, v);
          }
          const bool expected = low <= isovalue && isovalue < high;
          wrong += expected != (found.is_active[(z * 21 + y) * 37 + x] != 0);
        }
      }
    }
    EXPECT_EQ(wrong, 0u) << "isovalue " << isovalue;
    for (size_t i = 0; i < values.size(); ++i) {
      const double corner = found.corners[i], value = static_cast<double>(values[i]);
      if (std::isnan(corner) || static_cast<Value>(corner) == values[i]) continue;
      // Equal, except for the order in which slope and intercept are applied in double precision.
      const double rounding = 1e-15 * (40000 + 4 * std::abs(value));
      ASSERT_NEAR(corner, value, rounding) << i;
      ASSERT_TRUE((std::is_same_v<Value, double>) || std::abs(value) < rounding) << i;
    }
  }
}

struct Scaling {
  double slope, intercept;
};

class Scaled : public testing::TestWithParam<Scaling> {
 protected:
  template <class T>
  void check(double low, double high) {
    const auto [slope, intercept] = GetParam();
    SCOPED_TRACE(testing::Message() << sizeof(T) << " bytes from " << low << " to " << high);
    const auto voxels = integers<T>(low, high, 7);
    const auto store = store_of(voxels, slope, intercept);
    ASSERT_TRUE(store) << store.error().message;
    const StoreInfo info = StoreReader::open(*store)->info();
    EXPECT_EQ(info.mapping.max_error, 0);
    EXPECT_GT(info.mapping.scale, 0);
    EXPECT_EQ(info.mapping.bits, high - low <= 255 && sizeof(T) != 2 ? 8 : 16);
    std::vector<double> values;
    std::vector<float> singles;
    for (const T voxel : voxels) {
      values.push_back(intercept + slope * static_cast<double>(voxel));
      singles.push_back(static_cast<float>(values.back()));
    }
    expect_active_cells(*store, values);
    expect_active_cells(*store, singles);
    // The store is as small as the store of the same voxels without a slope, except for the digits
    // of the numbers in its metadata.
    const auto plain = store_of(voxels);
    EXPECT_EQ(StoreReader::open(*plain)->info().chunk_count, info.chunk_count);
    const double size = static_cast<double>(plain->size());
    EXPECT_NEAR(static_cast<double>(store->size()), size, slope < 0 ? 0.02 * size : 1024);
  }
};

TEST_P(Scaled, IntegersYieldTheActiveCellsOfTheirValues) {
  check<uint8_t>(0, 255);
  check<int8_t>(-128, 127);
  check<uint16_t>(0, 4095);
  check<int16_t>(-1024, 3071);
  check<int16_t>(-32768, 32767);
  check<uint32_t>(1000000, 1000200);
  check<int32_t>(-30000, 30000);
  check<uint64_t>(5000, 5100);
  check<int64_t>(-500, 20000);
}

INSTANTIATE_TEST_SUITE_P(Slopes, Scaled,
                         testing::Values(Scaling{2.0078, 0}, Scaling{0.1, 0}, Scaling{-1, 0},
                                         Scaling{1e-3, -1024}, Scaling{7.1098f, -1024},
                                         Scaling{-0.1, 3.3}, Scaling{1, -1024},
                                         Scaling{-2.0078f, 1000}, Scaling{1.0 / 3, 1e4}),
                         [](const auto& test) { return std::to_string(test.index); });

/// Floating-point numbers on a lattice are kept, and so are their cells.
template <class Real, class Make>
ValueMapping expect_kept(double low, double high, Make make, int bits, const char* what) {
  SCOPED_TRACE(what);
  std::vector<Real> voxels;
  for (const int32_t n : integers<int32_t>(low, high, 3)) voxels.push_back(make(n));
  const auto store = store_of(voxels);
  EXPECT_TRUE(store) << store.error().message;
  const ValueMapping mapping = StoreReader::open(*store)->info().mapping;
  EXPECT_EQ(mapping.max_error, 0);
  EXPECT_EQ(mapping.bits, bits);
  for (const Real voxel : voxels) {
    const double quantized =
        std::round((static_cast<double>(voxel) - mapping.offset) / mapping.scale);
    const auto value = static_cast<Real>(mapping.value(quantized));
    if (value == voxel) continue;
    ADD_FAILURE() << "expected " << voxel << ", found " << value;
    break;
  }
  expect_active_cells(*store, voxels);
  return mapping;
}

TEST(Lattice, FloatsOnAnEvenLatticeAreKept) {
  const auto kept = [](auto... arguments) { return expect_kept<float>(arguments...); };
  EXPECT_EQ(kept(
                0, 255, [](int n) { return static_cast<float>(n); }, 8, "integers")
                .scale,
            1);
  EXPECT_EQ(kept(
                -1024, 3071, [](int n) { return static_cast<float>(n); }, 16, "HU")
                .scale,
            1);
  EXPECT_EQ(kept(
                0, 5, [](int n) { return static_cast<float>(12 * n); }, 8, "labels")
                .scale,
            12);
  EXPECT_EQ(kept(
                -9, 99, [](int n) { return static_cast<float>(n) / 4; }, 8, "quarters")
                .scale,
            0.25);
  kept(
      0, 200, [](int n) { return 1e6f + static_cast<float>(n) / 8; }, 8, "far from 0");
  EXPECT_EQ(kept(
                -300, 9000, [](int n) { return static_cast<float>(n * 0.1); }, 16, "tenths")
                .scale,
            0.1);
  EXPECT_EQ(kept(
                0, 255, [](int n) { return static_cast<float>(n * 2.0078 - 1024); }, 8, "slope")
                .scale,
            2.0078);
  kept(
      -100, 30000, [](int n) { return static_cast<float>(n * 7.1098 - 1024); }, 16, "wide");
  kept(
      0, 255, [](int n) { return static_cast<float>(n / 255.0); }, 8, "normalised");
  kept(
      0, 65535, [](int n) { return static_cast<float>(n / 65535.0); }, 16, "normalised 16 bits");
  kept(
      0, 4095, [](int n) { return static_cast<float>((n - 1234.5) / 321.7); }, 16, "z-scores");
}

TEST(Lattice, DoublesOnAnEvenLatticeAreKept) {
  const auto kept = [](auto... arguments) { return expect_kept<double>(arguments...); };
  kept(
      -1024, 3071, [](int n) { return static_cast<double>(n); }, 16, "HU");
  kept(
      0, 255, [](int n) { return n * 0.1; }, 8, "tenths");
  kept(
      30, 250, [](int n) { return n * 0.1; }, 8, "tenths from 3 on");
  kept(
      0, 255, [](int n) { return n * 2.0078 - 1024; }, 8, "slope and intercept");
  kept(
      0, 255, [](int n) { return 1e15 + n; }, 8, "far from 0");
}

TEST(Lattice, TheErrorOfValuesThatFitNoLatticeIsStated) {
  // Values are rounded twice in single precision: values near 0 are differences of larger numbers,
  // and inherit their rounding errors.
  std::vector<float> singles;
  // Decimal fractions are not multiples of any double.
  std::vector<double> doubles;
  for (const int32_t n : integers<int32_t>(0, 255, 3)) {
    const float product = 7.1098f * static_cast<float>(n);
    singles.push_back(product - 1024.0f);
    doubles.push_back(static_cast<double>(n - 100) / 10);
  }
  const auto check = [](const auto& voxels, double most) {
    const auto store = store_of(voxels);
    ASSERT_TRUE(store) << store.error().message;
    const ValueMapping mapping = StoreReader::open(*store)->info().mapping;
    EXPECT_EQ(mapping.bits, 8);
    EXPECT_GT(mapping.max_error, 0);
    EXPECT_LT(mapping.max_error, most);
    using Real = std::decay_t<decltype(voxels[0])>;
    double found = 0;
    for (const Real voxel : voxels) {
      const double quantized =
          std::round((static_cast<double>(voxel) - mapping.offset) / mapping.scale);
      found = std::max(found,
                       std::abs(static_cast<double>(static_cast<Real>(mapping.value(quantized))) -
                                static_cast<double>(voxel)));
    }
    EXPECT_EQ(found, mapping.max_error);
  };
  check(singles, 2e-4);
  check(doubles, 1e-14);
}

TEST(Lattice, FewUnevenlySpacedValuesAreQuantized) {
  std::vector<float> voxels;
  for (const int32_t n : integers<int32_t>(0, 255, 3)) {
    voxels.push_back(std::exp(static_cast<float>(n) / 20));
  }
  const auto store = store_of(voxels);
  ASSERT_TRUE(store);
  const StoreInfo info = StoreReader::open(*store)->info();
  EXPECT_EQ(info.mapping.bits, 16);
  EXPECT_GT(info.mapping.max_error, 0);
  expect_store_of<float>(*store, kSize, voxels);
}

TEST(Lattice, PresentVoxelsStayExactIfOthersAreMissing) {
  std::vector<float> voxels;
  for (const int32_t n : integers<int32_t>(0, 255, 3)) {
    voxels.push_back(n == 77 ? std::nanf("") : static_cast<float>(n));
  }
  const auto store = store_of(voxels);
  ASSERT_TRUE(store);
  const StoreInfo info = StoreReader::open(*store)->info();
  EXPECT_EQ(info.mapping.max_error, 0);
  EXPECT_EQ(info.mapping.scale, 1);
  EXPECT_EQ(info.mapping.bits, 16);
  EXPECT_GT(info.missing_voxels, 0u);
  expect_store_of<float>(*store, kSize, voxels);
}

TEST(Lattice, IntegersWithACoarserStepTakeFewerValues) {
  const auto check = [](auto zero, int factor, int64_t offset, int bits) {
    using T = decltype(zero);
    std::vector<T> voxels;
    std::vector<double> values;
    for (const int32_t n : integers<int32_t>(0, 200, 3)) {
      voxels.push_back(static_cast<T>(n * factor + offset));
      values.push_back(-3.5 * static_cast<double>(voxels.back()));
    }
    SCOPED_TRACE(testing::Message() << sizeof(T) << " bytes times " << factor);
    const auto store = store_of(voxels, -3.5, 0);
    ASSERT_TRUE(store) << store.error().message;
    const StoreInfo info = StoreReader::open(*store)->info();
    EXPECT_EQ(info.mapping.max_error, 0);
    EXPECT_EQ(info.mapping.bits, bits);
    EXPECT_EQ(info.mapping.scale, 3.5 * factor);
    expect_active_cells(*store, values);
  };
  check(uint16_t{}, 16, 0, 8);
  check(uint16_t{}, 257, 5, 8);
  check(int16_t{}, 10, -1000, 8);
  check(uint32_t{}, 1000000, 7, 8);
  check(int64_t{}, 3, -5000000000, 8);
  std::vector<uint16_t> wide;
  for (const int32_t n : integers<int32_t>(0, 4095, 3))
    wide.push_back(static_cast<uint16_t>(n << 4));
  EXPECT_EQ(StoreReader::open(*store_of(wide))->info().mapping.scale, 16);
  // One voxel that is not a multiple suffices to change the step.
  wide[20000] = 3;
  EXPECT_EQ(StoreReader::open(*store_of(wide))->info().mapping.scale, 1);
}

TEST(Lattice, IntegersBeyondThePrecisionOfDoublesStateTheirError) {
  std::vector<uint64_t> voxels;
  for (const int32_t n : integers<int32_t>(0, 255, 3)) {
    voxels.push_back((uint64_t{1} << 62) + 1 + static_cast<uint64_t>(n));
  }
  const auto store = store_of(voxels);
  ASSERT_TRUE(store) << store.error().message;
  const StoreInfo info = StoreReader::open(*store)->info();
  EXPECT_EQ(info.mapping.bits, 8);
  EXPECT_EQ(info.range.max, 255);
  EXPECT_GE(info.mapping.max_error, 512);
}

TEST(MaxError, ChoosesTheFewestValues) {
  std::mt19937 random(1);
  std::vector<float> voxels;
  for (const int32_t n : integers<int32_t>(-100000, 100000, 3)) {
    voxels.push_back(static_cast<float>(n) / 1000 + static_cast<float>(random() % 1000) * 1e-6f);
  }
  voxels[5] = -100, voxels[6] = 100.001f;
  const auto finest = store_of(voxels);
  size_t before = finest->size();
  const double least = StoreReader::open(*finest)->info().mapping.max_error;
  for (const double max_error : {0.002, 0.01, 0.1, 1.0, 30.0, 1000.0}) {
    SCOPED_TRACE(max_error);
    BuildOptions options;
    options.max_error = max_error;
    const auto store = store_of(voxels, 1, 0, options);
    ASSERT_TRUE(store) << store.error().message;
    // If the size limit allows it, the builder cuts the blocks into more bands, so that isovalues
    // cost less.
    EXPECT_LT(static_cast<double>(store->size()), 1.05 * static_cast<double>(before));
    before = store->size();
    const StoreInfo info = StoreReader::open(*store)->info();
    EXPECT_LE(info.mapping.max_error, max_error);
    EXPECT_GT(info.mapping.max_error, std::min(0.8 * max_error, 99.0));
    EXPECT_EQ(info.mapping.bits, max_error < 0.4 ? 16 : 8);
    for (const float voxel : voxels) {
      const double quantized =
          std::round((static_cast<double>(voxel) - info.mapping.offset) / info.mapping.scale);
      ASSERT_LE(std::abs(info.mapping.value(quantized) - static_cast<double>(voxel)), max_error);
      ASSERT_GE(quantized, 0);
      ASSERT_LE(quantized, info.mapping.bits == 8 ? 255 : 65534);
    }
    expect_store_of<float>(*store, kSize, voxels);
  }
  EXPECT_LT(before, finest->size() / 4);
  BuildOptions options;
  options.max_error = least * 0.99;
  const auto refused = store_of(voxels, 1, 0, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::invalid_argument);
  EXPECT_NE(refused.error().message.find("at least 0.00153"), std::string::npos)
      << refused.error().message;
}

TEST(MaxError, HoldsForIntegersWithASlope) {
  const auto voxels = integers<int16_t>(-1024, 3071, 9);
  for (const double slope : {1.0, -2.5}) {
    for (const double max_error : {0.4, 1.0, 2.5, 10.0, 100.0}) {
      SCOPED_TRACE(testing::Message() << slope << " " << max_error);
      BuildOptions options;
      options.max_error = max_error;
      const auto store = store_of(voxels, slope, 10, options);
      ASSERT_TRUE(store) << store.error().message;
      const StoreInfo info = StoreReader::open(*store)->info();
      EXPECT_LE(info.mapping.max_error, max_error);
      EXPECT_EQ(info.mapping.max_error == 0, max_error < std::abs(slope));
      // The difference between each corner of a cell and its voxel is at most max_error.
      for (const double isovalue : {200.25, 1000.25}) {
        const FoundCells found = find_cells(*store, isovalue);
        for (size_t i = 0; i < voxels.size(); ++i) {
          if (std::isnan(found.corners[i])) continue;
          ASSERT_LE(std::abs(found.corners[i] - (10 + slope * voxels[i])), max_error);
        }
      }
    }
  }
}

TEST(Mapping, SuggestsIsovaluesThatNoVoxelHas) {
  VolumeGrid grid;
  grid.voxels = kSize;
  for (const auto& [slope, intercept] :
       std::vector<Scaling>{{1, 0}, {2.0078, 0}, {-0.1, 3}, {1e-3, -1024}, {7.1098, -1024}}) {
    const auto voxels = integers<uint8_t>(0, 255, 5);
    ArraySource<uint8_t> source(grid, voxels, "values", slope, intercept);
    MemorySink sink;
    const auto report = build_store(source, sink, {});
    ASSERT_TRUE(report);
    const auto survey = survey_volume(source);
    ASSERT_TRUE(survey);
    const auto [low, high] = std::minmax({intercept, intercept + slope * 255});
    EXPECT_DOUBLE_EQ(survey->min, low);
    EXPECT_DOUBLE_EQ(survey->max, high);
    const auto metadata = report->info.metadata;
    const size_t at = metadata.find("\"suggested_isovalues\":[") + 23;
    ASSERT_LT(at, metadata.size()) << metadata;
    const double isovalue = std::stod(metadata.substr(at));
    EXPECT_GT(isovalue, low);
    EXPECT_LT(isovalue, high);
    const double voxel = (isovalue - intercept) / slope;
    EXPECT_GT(std::abs(voxel - std::round(voxel)), 0.2) << isovalue;
    EXPECT_LT(metadata.find_first_of(",]", at) - at, 11u) << metadata.substr(at, 40);
  }
}

/// Compares real volumes of 8-bit voxels with a slope to the same voxels without it.
class RealScaled : public testing::TestWithParam<const char*> {};

TEST_P(RealScaled, IsAsSmallAsItsVoxels) {
  const char* chosen = std::getenv("ISOSPLAT_VOLUMES");
  const std::filesystem::path folder = chosen ? chosen : ISOSPLAT_SOURCE "/../shared/volumes";
  if (!std::filesystem::exists(folder / GetParam())) {
    GTEST_SKIP() << GetParam() << " is not in " << folder;
  }
  const auto volume = import::open_volume(folder / GetParam(), {});
  ASSERT_TRUE(volume) << volume.error().message;
  VolumeSource& source = *volume->source;
  const VolumeHeader& header = source.header();
  ASSERT_EQ(header.type, VoxelType::u8);
  EXPECT_NE(header.slope, 1);
  MemorySink scaled;
  ASSERT_TRUE(build_store(source, scaled, {}));
  std::vector<uint8_t> voxels(voxel_count(header.grid.voxels));
  ASSERT_TRUE(
      source.read_slices(0, header.grid.voxels.z, std::as_writable_bytes(std::span(voxels))));
  const auto plain = build_store_bytes<uint8_t>(header.grid, voxels);
  ASSERT_TRUE(plain);
  const double size = static_cast<double>(plain->size());
  EXPECT_NEAR(static_cast<double>(scaled.bytes.size()), size, 0.01 * size);
  EXPECT_LT(scaled.bytes.size(), voxels.size());
  const StoreInfo info = StoreReader::open(scaled.bytes)->info();
  EXPECT_EQ(info.mapping.max_error, 0);
  EXPECT_EQ(info.mapping.bits, 8);
}

INSTANTIATE_TEST_SUITE_P(Volumes, RealScaled, testing::Values("CT_AVM.nii.gz", "ct_shear.nii.gz"),
                         [](const auto& test) {
                           const std::string name = test.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace isosplat
