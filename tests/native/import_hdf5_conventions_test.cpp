// The conventions of programs that write HDF5: where voxels lie, which of them have no value, and
// which array is read. The files are those of hdf5/make_conventions.py; the voxel at (10, 20, 30) +
// (0.5·i, 2·j, 3·k) has the value 100·k + 10·j + i.
#include <cmath>
#include <fstream>
#include <set>

#include "shared/import/hdf5/hdf5.h"
#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using test::expect_error;
using test::expect_note;
using test::open;
using test::read_all;
using test::TempFolder;
using test::write_file;

std::filesystem::path file_of(const std::string& name) {
  return std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "tests/native/hdf5/conventions" / name;
}

/// The expected grid of a file: its unit in mm, and the position of the first voxel along each axis
/// in that unit.
struct Place {
  double unit = 1;
  Vec3d first{10, 20, 30};
  Vec3d step{0.5, 2, 3};
};

/// Checks every voxel by its position. Returns the expected values of absent voxels, and the values
/// of voxels that differ.
std::multiset<double> expect_voxels(OpenVolume& volume, const Place& place = {}) {
  std::multiset<double> absent;
  if (!volume.source) return absent;
  const VolumeHeader& header = volume.source->header();
  const VolumeGrid& grid = header.grid;
  EXPECT_EQ(int64_t{grid.voxels.x} * grid.voxels.y * grid.voxels.z, 5 * 6 * 7);
  const auto values = read_all(*volume.source);
  std::set<double> seen;
  size_t at = 0;
  for (int z = 0; z < grid.voxels.z; ++z) {
    for (int y = 0; y < grid.voxels.y; ++y) {
      for (int x = 0; x < grid.voxels.x; ++x, ++at) {
        const Vec3d world = grid.world({double(x), double(y), double(z)}) * (1 / place.unit);
        const auto index = [](double position, double first, double step) {
          const double i = (position - first) / step;
          EXPECT_NEAR(i, std::round(i), 1e-3);
          return std::round(i);
        };
        const double expected = 100.0 * index(world.z, place.first.z, place.step.z) +
                                10.0 * index(world.y, place.first.y, place.step.y) +
                                index(world.x, place.first.x, place.step.x);
        seen.insert(expected);
        const double value = header.value(values[at]);
        if (value != expected) absent.insert(std::isnan(value) ? expected : value);
      }
    }
  }
  EXPECT_EQ(seen.size(), 210u);
  EXPECT_EQ(*seen.begin(), 0);
  EXPECT_EQ(*seen.rbegin(), 654);
  return absent;
}

/// Opens a file, and expects that all its voxels are right. Returns its notes.
std::vector<std::string> expect_file(const std::string& name, const Place& place = {},
                                     const ImportOptions& options = {}) {
  SCOPED_TRACE(name);
  auto volume = open(file_of(name), options);
  EXPECT_EQ(expect_voxels(volume, place), (std::multiset<double>{}));
  return volume.notes;
}

ImportOptions chosen(std::optional<int64_t> channel, std::optional<int64_t> time_step) {
  ImportOptions options;
  options.channel = channel;
  options.time_step = time_step;
  return options;
}

using Notes = std::vector<std::string>;

/// A note reports a property that the file does not state. It must not occur if the file states the
/// property.
TEST(ImportHdf5Conventions, FilesThatStateTheirAxesAndSpacingHaveNoNote) {
  EXPECT_EQ(expect_file("xyz.nc"), Notes{});
  EXPECT_EQ(expect_file("many.nc"), Notes{});
  EXPECT_EQ(expect_file("unlimited.nc"), Notes{});
  EXPECT_EQ(expect_file("time.nc", {}, chosen({}, 1)), Notes{});
  EXPECT_EQ(expect_file("scales.h5"), Notes{});
  EXPECT_EQ(expect_file("nexus_2013.nxs"), Notes{});
  EXPECT_EQ(expect_file("points.vtkhdf"), Notes{});
  EXPECT_EQ(expect_file("turned.vtkhdf"), Notes{});
  EXPECT_EQ(expect_file("itk.hdf5"), Notes{});
  EXPECT_EQ(expect_file("berkeley.emd", {1e-6}), Notes{});
  EXPECT_EQ(expect_file("py4dstem.emd", {1e-6}), Notes{});
  EXPECT_EQ(expect_file("openpmd.h5"), Notes{});
  EXPECT_EQ(expect_file("imaris.ims", {1e-3}, chosen(1, 1)), Notes{});
}

TEST(ImportHdf5Conventions, EveryAssumptionHasItsNote) {
  const auto descending = expect_file("descending.nc");
  for (const auto& note : descending) EXPECT_EQ(note.find("spacing"), note.npos) << note;
  const auto note_of = [](const Notes& notes, const std::string& part) {
    return std::count_if(notes.begin(), notes.end(),
                         [&](const std::string& note) { return note.find(part) != note.npos; });
  };
  const Place unplaced{1, {0, 0, 0}, {1, 1, 1}};
  const Notes labels = expect_file("labels.h5", unplaced);
  ASSERT_EQ(labels.size(), 1u);
  EXPECT_EQ(note_of(labels, "no voxel spacing was found"), 1);
  const Notes named = expect_file("named.h5", unplaced);
  ASSERT_EQ(named.size(), 2u);
  EXPECT_EQ(note_of(named, "are named 'energy', 'theta' and 'phi': they are read as z, y and x"),
            1);
  EXPECT_EQ(note_of(expect_file("cells.vtkhdf"), "a voxel at the centre of its cell"), 1);
  EXPECT_EQ(note_of(expect_file("chimera.cmap", {1e-7}), "ångström"), 1);
  EXPECT_EQ(note_of(expect_file("turned.cmap", {1e-7}), "ångström"), 1);
  const Notes matlab = expect_file("matlab.mat", unplaced);
  EXPECT_EQ(note_of(matlab, "V(row, column, slice)"), 1);
  EXPECT_EQ(note_of(matlab, "does not name"), 0);
  const Notes velox = expect_file("velox.emd", {1e-6, {0, 0, 0}, {0.5, 2, 1e6}});
  EXPECT_EQ(note_of(velox, "no voxel spacing along z"), 1);
}

TEST(ImportHdf5Conventions, DepthsAreNegated) {
  auto volume = open(file_of("depth.nc"));
  const VolumeGrid& grid = volume.source->header().grid;
  expect_note(volume, "the positions along lev are depths");
  const auto values = read_all(*volume.source);
  for (size_t i = 0; i < values.size(); ++i) {
    const double x = double(i % 5), y = double(i / 5 % 6), z = double(i / 30);
    const Vec3d world = grid.world({x, y, z}) * 1e-3;
    EXPECT_NEAR(values[i],
                100 * (-world.z - 30) / 3 + 10 * (world.y - 20) / 2 + (world.x - 10) / 0.5, 1e-6);
  }
}

TEST(ImportHdf5Conventions, ValuesWithoutMeaningAreAbsent) {
  auto numbers = open(file_of("unsigned.nc"));
  EXPECT_EQ(numbers.source->header().type, VoxelType::f32);
  expect_note(numbers, "voxels of the values 65534 and 600 and 65533 have no value");
  EXPECT_EQ(expect_voxels(numbers), (std::multiset<double>{0, 40000, 600}));
  auto lowest = open(file_of("lowest.nc"));
  EXPECT_EQ(expect_voxels(lowest), (std::multiset<double>{0}));
  EXPECT_TRUE(std::isnan(read_all(*lowest.source)[0]));

  auto packed = open(file_of("packed.nc"));
  EXPECT_EQ(packed.source->header().slope, 0.5);
  expect_note(packed, "voxels below 15, or above 330 have no value");
  size_t absent = 0;
  for (const double value : read_all(*packed.source)) {
    if (std::isnan(value)) ++absent;
  }
  EXPECT_EQ(absent, 5u + 9u);  // 0 to 4; 641 to 644 and 650 to 654
}

TEST(ImportHdf5Conventions, ValuesWithoutMeaningAreKeptOnRequest) {
  ImportOptions options;
  options.finds_missing_values = false;
  auto numbers = open(file_of("unsigned.nc"), options);
  EXPECT_EQ(numbers.source->header().type, VoxelType::u16);
  EXPECT_EQ(expect_voxels(numbers), (std::multiset<double>{65534, 40000}));
}

TEST(ImportHdf5Conventions, TheFinestImageOfAPyramidIsChosen) {
  expect_error(file_of("imaris.ims"),
               "expected one channel, found 2: 0 (DAPI), 1 (GFP): choose one with --channel");
  expect_error(file_of("imaris.ims"), "expected one volume, found 2 time steps", chosen(1, {}));
  expect_error(file_of("imaris.ims"), "expected a --channel of 0, 1, found 2", chosen(2, 0));
  const auto paths = hdf5_datasets(file_of("imaris.ims")).value();
  ASSERT_EQ(paths.size(), 4u);
  ImportOptions listed;
  listed.dataset = paths[3];
  expect_file("imaris.ims", {1e-3}, listed);
  ImportOptions coarse;
  coarse.dataset = "/DataSet/ResolutionLevel 1/TimePoint 1/Channel 1/Data";
  auto volume = open(file_of("imaris.ims"), coarse);
  EXPECT_EQ(volume.source->header().grid.voxels, (Index3{3, 3, 4}));
  EXPECT_NEAR(volume.source->header().grid.spacing.y, 2 * 2e-3, 1e-9);

  expect_error(file_of("bdv.h5"), "expected one setup, found 2: 0, 1: choose one with --channel");
  auto bdv = open(file_of("bdv.h5"), chosen(1, 1));
  EXPECT_EQ(bdv.source->header().type, VoxelType::u16);
  EXPECT_EQ(bdv.notes, Notes{});
  EXPECT_EQ(expect_voxels(bdv, {1e-3, {0, 0, 0}}), (std::multiset<double>{40000}));
  coarse.dataset = "/t00001/s01/1/cells";
  const VolumeGrid half = open(file_of("bdv.h5"), coarse).source->header().grid;
  EXPECT_NEAR(half.spacing.x, 1e-3, 1e-9);
  EXPECT_NEAR(half.world({0, 0, 0}).x, 0.25e-3, 1e-9);
}

TEST(ImportHdf5Conventions, PositionsThatWereNotWrittenAreIgnored) {
  auto volume = open(file_of("unwritten_axes.nc"));
  EXPECT_EQ(expect_voxels(volume, {1, {0, 0, 0}, {1, 1, 1}}), std::multiset<double>{});
  expect_note(volume, "no voxel spacing was found in the HDF5 file");
}

TEST(ImportHdf5Conventions, WithoutItsXmlFileBigDataViewersSpacingIsNoted) {
  const TempFolder folder;
  std::ifstream file(file_of("bdv.h5"), std::ios::binary);
  write_file(folder / "v.h5", std::string{std::istreambuf_iterator<char>(file), {}});
  auto volume = open(folder / "v.h5", chosen(1, 1));
  expect_note(volume, "an XML file, which is not beside this one");
  EXPECT_EQ(volume.source->header().grid.spacing.x, 1);
}

TEST(ImportHdf5Conventions, ASpacingOfTheUserKeepsDirections) {
  ImportOptions options;
  options.spacing = Vec3d{0.5, 2, 3};
  expect_file("descending.nc", {}, options);
  options.spacing = Vec3d{2, 3, 0.5};  // along the array's own x, y and z
  expect_file("turned.vtkhdf", {}, options);
}

TEST(ImportHdf5Conventions, Errors) {
  expect_error(file_of("time.nc"), "found 2 time steps: choose one with --time-step 0");
  expect_error(file_of("time.nc"), "--time-step from 0 to 1, found 2", chosen({}, 2));
  expect_error(file_of("xyz.nc"), "a --channel from 0 to 0, found 1", chosen(1, {}));
}

}  // namespace
}  // namespace isosplat::import
