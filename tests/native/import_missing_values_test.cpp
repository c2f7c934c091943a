#include <algorithm>
#include <cmath>
#include <functional>

#include "shared/import/voxels/missing_values.h"
#include "tests/native/import_checks.h"

// The choice of the fill value. It is a declared value, or a value that programs use for "no value"
// and that has no other explanation in this volume. Objects, backgrounds and labels of one value
// are kept.
namespace isosplat::import {
namespace {

using test::bytes_of;
using test::expect_note;
using test::nrrd_header;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

/// Floats from 0 to 59; one in five is `fill`.
std::string with_fill(float fill) {
  std::vector<float> values;
  for (int i = 0; i < 60; ++i) values.push_back(i % 5 == 0 ? fill : static_cast<float>(i));
  return bytes_of(values);
}

TEST(RuleMissingValues, AFillValueOfFloatsIsFoundAndNoted) {
  const TempFolder folder;
  const std::string header = nrrd_header(kSize, "float", "endian: little\nencoding: raw\n\n");
  for (const float fill : {-9999.f, -3.4e38f, 1e20f, 99999.f}) {
    write_file(folder / "v.nrrd", header + with_fill(fill));
    auto volume = open(folder / "v.nrrd");
    expect_note(volume, "--missing-value none keeps them");
    const auto values = read_all(*volume.source);
    for (size_t i = 0; i < 60; ++i) EXPECT_EQ(std::isnan(values[i]), i % 5 == 0);
    ImportOptions options;
    options.finds_missing_values = false;
    auto kept = open(folder / "v.nrrd", options);
    EXPECT_EQ(read_all(*kept.source)[5], static_cast<double>(fill));
  }
  // A background of zeros and an ordinary value are not fill values.
  write_file(folder / "v.nrrd", header + with_fill(0));
  EXPECT_FALSE(std::isnan(read_all(*open(folder / "v.nrrd").source)[5]));
  write_file(folder / "v.nrrd", header + with_fill(-20));
  EXPECT_FALSE(std::isnan(read_all(*open(folder / "v.nrrd").source)[5]));
}

/// Integers from 0 to 59; one in five is `fill`.
template <class T>
std::string integers_with_fill(T fill) {
  std::vector<T> values;
  for (int i = 0; i < 60; ++i) values.push_back(i % 5 == 0 ? fill : static_cast<T>(i));
  return bytes_of(values);
}

TEST(RuleMissingValues, AFillValueOfIntegersIsKeptAndNoted) {
  const TempFolder folder;
  const auto check = [&](const char* type, const std::string& voxels, const char* value) {
    SCOPED_TRACE(value);
    const std::string head = std::string("endian: little\nencoding: raw\n\n");
    write_file(folder / "v.nrrd", nrrd_header(kSize, type, head) + voxels);
    auto volume = open(folder / "v.nrrd");
    EXPECT_NE(volume.source->header().type, VoxelType::f32);
    EXPECT_NE(volume.source->header().type, VoxelType::f64);
    EXPECT_EQ(read_all(*volume.source)[5], std::stod(value));
    expect_note(volume, fmt::format("--missing-value={}", value));
    ImportOptions options;
    options.missing_value = std::stod(value);  // the option in the note must work
    EXPECT_TRUE(std::isnan(read_all(*open(folder / "v.nrrd", options).source)[5]));
  };
  check("short", integers_with_fill<int16_t>(-9999), "-9999");
  check("short", integers_with_fill<int16_t>(-32768), "-32768");
  check("short", integers_with_fill<int16_t>(-3024), "-3024");
  check("ushort", integers_with_fill<uint16_t>(65535), "65535");
  check("int", integers_with_fill<int32_t>(-2147483647 - 1), "-2147483648");
  check("uint", integers_with_fill<uint32_t>(4294967295u), "4294967295");

  // Ordinary values, a value close to others, and the limits of 8-bit types are not fill values.
  const auto has_note = [&](const char* type, const std::string& voxels) {
    write_file(folder / "v.nrrd",
               nrrd_header(kSize, type, "endian: little\nencoding: raw\n\n") + voxels);
    const auto volume = open(folder / "v.nrrd");
    return std::ranges::any_of(volume.notes, [](const std::string& note) {
      return note.find("--missing-value") != std::string::npos;
    });
  };
  EXPECT_FALSE(has_note("short", integers_with_fill<int16_t>(0)));
  EXPECT_FALSE(has_note("short", integers_with_fill<int16_t>(-100)));
  EXPECT_FALSE(has_note("uchar", integers_with_fill<uint8_t>(255)));
}

TEST(RuleMissingValues, AnOptionSetsThemForEveryType) {
  const TempFolder folder;
  write_file(folder / "v.nrrd",
             nrrd_header(kSize, "short", "spacings: 1 1 1\nendian: little\nencoding: raw\n\n") +
                 bytes_of(pattern_voxels<int16_t>(kSize)));
  EXPECT_EQ(open(folder / "v.nrrd").source->header().type, VoxelType::i16);
  ImportOptions options;
  options.missing_value = 4;
  auto volume = open(folder / "v.nrrd", options);
  auto values = read_all(*volume.source);
  EXPECT_TRUE(std::isnan(values[4]));
  values[4] = 4;
  EXPECT_EQ(values, pattern_voxels<double>(kSize));
  expect_note(volume, "--missing-value requests");
}

/// A volume of 16³ floats, written and opened.
struct Field {
  std::function<double(int x, int y, int z)> value;
  const char* type = "float";

  OpenVolume open() const {
    std::string voxels;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
      const double v = value(i % 16, i / 16 % 16, i / 256);
      voxels += std::string_view(type) == "float" ? bytes_of(std::vector{static_cast<float>(v)})
                                                  : bytes_of(std::vector{static_cast<int16_t>(v)});
    }
    write_file(
        folder / "v.nrrd",
        nrrd_header({16, 16, 16}, type, "spacings: 1 1 1\nendian: little\nencoding: raw\n\n") +
            voxels);
    return test::open(folder / "v.nrrd");
  }
  TempFolder folder = {};
};

/// A repeatable number from 0 to 1 for each voxel.
double noise(int x, int y, int z) {
  const uint32_t i = static_cast<uint32_t>(x + 16 * y + 256 * z) * 2654435761u;
  return static_cast<double>((i ^ i >> 15) % 10007) / 10007;
}

bool in_box(int x, int y, int z) {
  return x > 3 && x < 10 && y > 4 && y < 10 && z > 3 && z < 10;
}

bool in_ball(int x, int y, int z) {
  return (x - 7.5) * (x - 7.5) + (y - 7.5) * (y - 7.5) + (z - 7.5) * (z - 7.5) < 60;
}

size_t count_absent(OpenVolume& volume) {
  const auto values = read_all(*volume.source);
  return static_cast<size_t>(std::ranges::count_if(values, [](double v) { return std::isnan(v); }));
}

TEST(RuleMissingValues, AnObjectOfOneValueIsKept) {
  struct {
    double object, rest;
  } const cases[] = {{255, 2},    {1000, 10},  {1, 0.01},   {-1000, 5},
                     {9999, 100}, {-9999, 10}, {32768, 70}, {123456, 1}};
  for (const auto& [object, rest] : cases) {
    SCOPED_TRACE(object);
    const Field field{[&, object = object, rest = rest](int x, int y, int z) {
      return in_box(x, y, z) ? object : rest * noise(x, y, z);
    }};
    auto volume = field.open();
    EXPECT_EQ(count_absent(volume), 0u);
    expect_note(volume, "kept as the value of objects");
    expect_note(volume, fmt::format("--missing-value={:.10g}", object));
  }
}

TEST(RuleMissingValues, ABackgroundOfOneValueIsKept) {
  for (const double background : {-1000.0, 255.0, 100000.0}) {
    SCOPED_TRACE(background);
    const Field field{
        [&](int x, int y, int z) { return in_ball(x, y, z) ? 8 * noise(x, y, z) : background; }};
    auto volume = field.open();
    EXPECT_EQ(count_absent(volume), 0u);
    expect_note(volume, "kept as the background");
  }
}

TEST(RuleMissingValues, AClassicValueAroundTheDataOrScatteredHasNoValue) {
  size_t outside = 0, scattered = 0;
  const auto is_scattered = [](int x, int y, int z) { return noise(z, x, y) < 0.1; };
  for (int i = 0; i < 4096; ++i) {
    outside += !in_ball(i % 16, i / 16 % 16, i / 256);
    scattered += is_scattered(i % 16, i / 16 % 16, i / 256);
  }
  for (const double fill : {-9999.0, -999.0, 1e30, -3.4028234663852886e38, -32768.0}) {
    SCOPED_TRACE(fill);
    const Field around{
        [&](int x, int y, int z) { return in_ball(x, y, z) ? 8 * noise(x, y, z) : fill; }};
    auto a = around.open();
    EXPECT_EQ(count_absent(a), outside);
    expect_note(a, "--missing-value none keeps them");
    const Field inside{
        [&](int x, int y, int z) { return is_scattered(x, y, z) ? fill : 8 * noise(x, y, z); }};
    auto b = inside.open();
    EXPECT_EQ(count_absent(b), scattered);
    expect_note(b, "--missing-value none keeps them");
  }
  // No object has such a value.
  const Field hole{[](int x, int y, int z) { return in_box(x, y, z) ? 1e20 : noise(x, y, z); }};
  auto volume = hole.open();
  EXPECT_GT(count_absent(volume), 0u);
}

TEST(RuleMissingValues, AClassicValueThatTheOthersExplainIsKept) {
  // The other values range from 0 to 900, so 999 may be an ordinary value.
  const Field field{
      [](int x, int y, int z) { return in_ball(x, y, z) ? 900 * noise(x, y, z) : 999.0; }};
  auto volume = field.open();
  EXPECT_EQ(count_absent(volume), 0u);
}

/// A slice source in memory with a fill value in its header.
OpenVolume declaring(const Field& field, FillValue fill) {
  ImportOptions options;
  options.finds_missing_values = false;
  auto volume = open_volume(field.folder / "v.nrrd", options);
  EXPECT_TRUE(volume);
  volume->fill_value = fill;
  auto result = with_missing_values(std::move(*volume), {});
  EXPECT_TRUE(result);
  return std::move(*result);
}

TEST(RuleMissingValues, ADeclaredValueIsComparedInTheVoxelsPrecision) {
  const Field field{[](int x, int y, int z) {
    return in_ball(x, y, z) ? 8 * noise(x, y, z) : static_cast<double>(0.1f - 1);
  }};
  field.open();
  auto volume = declaring(field, {0.1 - 1, 0.1 - 1});
  EXPECT_GT(count_absent(volume), 1000u);
  expect_note(volume, "according to the file's header");
}

// GDAL writes such a text for −FLT_MAX, but no voxel has exactly this value.
TEST(RuleMissingValues, ADeclaredValueThatNoVoxelHasDoesNotEndTheSearch) {
  const Field field{[](int x, int y, int z) {
    return in_ball(x, y, z) ? 8 * noise(x, y, z) : -3.4028234663852886e38;
  }};
  field.open();
  for (const double declared : {-3.39999999999999996e38, -9999.0, -3.40282e38}) {
    auto volume = declaring(field, {declared, declared});
    EXPECT_GT(count_absent(volume), 1000u) << declared;
  }
  // A value that the type cannot have does not turn integers into floats.
  const Field integers{[](int x, int y, int z) { return 100 * noise(x, y, z); }, "short"};
  integers.open();
  auto volume = declaring(integers, {-99999, -99999});
  EXPECT_EQ(volume.source->header().type, VoxelType::i16);
  EXPECT_TRUE(volume.notes.empty());
}

TEST(RuleMissingValues, ThePaddingOfALabelMapIsItsBackground) {
  for (const int labels : {1, 2, 40}) {
    SCOPED_TRACE(labels);
    const Field field{
        [&](int x, int y, int z) { return in_ball(x, y, z) ? 1 + (x + y) % labels : 0.0; },
        "short"};
    field.open();
    auto volume = declaring(field, {0, 0, false});
    EXPECT_EQ(volume.source->header().type, VoxelType::i16);
    expect_note(volume, "the background of labels");
    expect_note(volume, "--missing-value=0 removes them");
  }
}

}  // namespace
}  // namespace isosplat::import
