// Files in netCDF's classic format: how a variable is chosen, and damaged or contradictory headers.
// tests/conformance compares complete volumes.
#include "tests/conformance/netcdf_writer.h"
#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using conformance::NetcdfWriter;
using conformance::Number;
using test::expect_error;
using test::expect_note;
using test::offered_choices;
using test::open;
using test::TempFolder;
using test::write_file;

std::vector<double> counted(size_t count) {
  std::vector<double> values;
  for (size_t i = 0; i < count; ++i) values.push_back(static_cast<double>(i));
  return values;
}

/// Two volumes of 3 × 4 × 5 voxels, along the axes z, y and x, without positions.
NetcdfWriter two_volumes(int version = 1) {
  NetcdfWriter file(version);
  file.axes = {{"z", 3}, {"y", 4}, {"x", 5}};
  file.arrays = {{"density", {0, 1, 2}, Number::i16, counted(60)},
                 {"pressure", {0, 1, 2}, Number::f32, counted(60)}};
  return file;
}

class ImportNetcdf : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& bytes) {
    const auto path = folder_ / "a.nc";
    write_file(path, bytes);
    return path;
  }

 private:
  TempFolder folder_;
};

TEST_F(ImportNetcdf, AVariableIsChosenByItsName) {
  const auto path = write(two_volumes().bytes());
  expect_error(path,
               "expected one volume, found 2: density (i16, 3 × 4 × 5), pressure (f32, 3 × 4 × 5): "
               "choose one with --dataset");
  const auto choices = offered_choices(path);
  ASSERT_EQ(choices.size(), 2u);
  EXPECT_EQ(choices[1].dataset, "pressure");
  ImportOptions options;
  options.dataset = "pressure";
  const OpenVolume volume = open(path, options);
  EXPECT_EQ(volume.source->header().type, VoxelType::f32);
  EXPECT_EQ(volume.source->header().format, "netCDF");
  expect_note(volume, "no voxel spacing was found in the netCDF file: 1,1,1 is assumed");
  options.dataset = "velocity";
  expect_error(path, "expected a variable velocity, found density", options);
  EXPECT_EQ(format_of_file(path), "netCDF");
}

TEST_F(ImportNetcdf, UnevenPositionsAreRefused) {
  NetcdfWriter file = two_volumes();
  file.arrays.pop_back();
  file.arrays.push_back({"z", {0}, Number::f32, {0, 1, 5}, {{"units", "m"}}});
  expect_error(write(file.bytes()), "expected evenly spaced positions along the axis z");
}

TEST_F(ImportNetcdf, IncompleteFiles) {
  for (const int version : {1, 2, 5}) {
    const std::string whole = two_volumes(version).bytes();
    ImportOptions options;
    options.dataset = "pressure";
    expect_error(write(whole.substr(0, whole.size() - 1)), "the file is incomplete", options);
    expect_error(write(whole.substr(0, 50)), "expected a whole header", options);
    expect_error(write(whole.substr(0, 4)), "", options);
  }
}

/// A header of CDF-1 before its lists, and big-endian words.
std::string words(std::initializer_list<uint32_t> numbers) {
  std::string out;
  for (const uint32_t number : numbers) conformance::put(out, number, true);
  return out;
}

TEST_F(ImportNetcdf, HostileHeaders) {
  const std::string start = std::string("CDF\1", 4) + words({0});
  const std::string end(4096, '\0');
  // 2^32 − 1 dimensions, attributes, variables; a name of 2^32 − 1 bytes; an unknown tag.
  expect_error(write(start + words({10, ~0u}) + end), "expected a list that fits the file");
  expect_error(write(start + words({0, 0, 12, ~0u}) + end), "expected a list that fits the file");
  expect_error(write(start + words({0, 0, 0, 0, 11, ~0u}) + end),
               "expected a list that fits the file");
  expect_error(write(start + words({10, 1, ~0u}) + end), "expected a whole header");
  expect_error(write(start + words({7, 1}) + end), "expected a list with the tag 10, found 7");
  // A variable with a dimension that does not exist, and one of an unknown type.
  const std::string dimension = words({10, 1, 1, 'x' << 24, 4, 0, 0});
  expect_error(write(start + dimension + words({11, 1, 1, 'a' << 24, 1, 5}) + end),
               "expected one of 1 dimensions, found number 5");
  expect_error(
      write(start + dimension + words({11, 1, 1, 'a' << 24, 1, 0, 0, 0, 99, 16, 100}) + end),
      "expected a type, found 99");
  // Sizes whose product overflows.
  NetcdfWriter file(5);
  file.axes = {{"z", 2}, {"y", 2}, {"x", 2}};
  file.arrays = {{"a", {0, 1, 2}, Number::f64, counted(8)}};
  std::string bytes = file.bytes();
  for (const char* name : {"z", "y", "x"}) {
    // A name takes 12 bytes, and the size that follows 8.
    const size_t at = bytes.find(words({0, 1}) + name);
    ASSERT_NE(at, bytes.npos);
    bytes.replace(at + 12, 8, words({0x7fffffff, 0}));
  }
  expect_error(write(bytes), "more than 2^64");
}

TEST_F(ImportNetcdf, AFileThatIsStillWrittenHasTheRecordsThatFit) {
  NetcdfWriter file(2);
  file.axes = {{"time", 2, true}, {"z", 3}, {"y", 4}, {"x", 5}};
  file.arrays = {{"a", {0, 1, 2, 3}, Number::i16, counted(120)}};
  file.records = 2;
  file.is_streamed = true;
  expect_error(write(file.bytes()), "found 2 time steps: choose one with --time-step 0");
}

}  // namespace
}  // namespace isosplat::import
