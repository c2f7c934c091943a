// The times of a file's steps, and the descriptions of its channels, as its header states them.
#include "shared/import/volume/time_axis.h"
#include "tests/native/import_checks.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::bytes_of;
using test::offered_choices;
using test::pattern_voxels;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

std::vector<double> times_of(const std::vector<VolumeChoice>& choices) {
  std::vector<double> times;
  for (const VolumeChoice& choice : choices) {
    if (choice.time) times.push_back(*choice.time);
  }
  return times;
}

std::string three_steps() {
  std::string data;
  for (int t = 0; t < 3; ++t) data += bytes_of(pattern_voxels<int16_t>(kSize, 1, 100 * t));
  return data;
}

TEST(ImportTimes, AreRoundedToTheDigitsOfAHeader) {
  EXPECT_EQ(TimeAxis::regular(0, 0.1, 4, "s").values, (std::vector<double>{0, 0.1, 0.2, 0.3}));
  EXPECT_EQ(TimeAxis::regular(0, double{0.72f}, 4, "s").values,
            (std::vector<double>{0, 0.72, 1.44, 2.16}));
  EXPECT_EQ(TimeAxis::regular(-5, 1500, 3, "").values, (std::vector<double>{-5, 1495, 2995}));
  EXPECT_EQ(TimeAxis::regular(0, 2e-9, 3, "").values, (std::vector<double>{0, 2e-9, 4e-9}));
  EXPECT_EQ(TimeAxis::regular(0, 3e20, 2, "").values, (std::vector<double>{0, 3e20}));
}

TEST(ImportTimes, AreLeftOutIfTheyAreInvalid) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double distance : {0.0, -1.0, kNaN, std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(TimeAxis::regular(0, distance, 3, "s").values.empty()) << distance;
  }
  EXPECT_TRUE(TimeAxis::regular(kNaN, 1, 3, "s").values.empty());
  EXPECT_TRUE(TimeAxis::regular(1e300, 1, 3, "s").values.empty());  // they do not ascend
  EXPECT_TRUE(TimeAxis::of({1, 1}, "s").values.empty());
  EXPECT_EQ(TimeAxis::of({1, 2}, std::string(1000, 's')).unit, "");
  EXPECT_LE(TimeAxis::regular(0, 1, int64_t{1} << 40, "s").values.size(), 10'000u);
}

TEST(ImportTimes, OfNifti) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3, 3};
  file.voxels = three_steps();
  file.time_distance = 0.72f;
  file.time_offset = 10;
  for (const auto& [units, unit] : {std::pair{8, "s"}, {16, "ms"}, {24, "µs"}}) {
    file.time_units = static_cast<char>(units);
    write_file(folder / "v.nii", file.bytes());
    const auto offered = offered_choices(folder / "v.nii");
    EXPECT_EQ(times_of(offered), (std::vector<double>{10, 10.72, 11.44}));
    EXPECT_EQ(offered.at(0).time_unit, unit);
    EXPECT_EQ(offered.at(1).label, std::string("time step 1 (10.72 ") + unit + ")");
  }
  // The fourth axis has frequencies, or its meaning is unknown.
  for (const int units : {0, 32}) {
    file.time_units = static_cast<char>(units);
    write_file(folder / "v.nii", file.bytes());
    const auto offered = offered_choices(folder / "v.nii");
    ASSERT_EQ(offered.size(), 3u);
    EXPECT_TRUE(times_of(offered).empty());
    EXPECT_EQ(offered[1].label, "time step 1");
  }
}

TEST(ImportTimes, OfNrrd) {
  const TempFolder folder;
  const auto offered_with = [&](const std::string& lines) {
    write_file(folder / "v.nrrd",
               "NRRD0004\ntype: short\ndimension: 4\nsizes: 3 5 4 3\n"
               "kinds: time domain domain domain\n" +
                   lines + "endian: little\nencoding: raw\n\n" + three_steps());
    return offered_choices(folder / "v.nrrd");
  };
  const auto offered =
      offered_with("spacings: 0.25 1 1 1\naxismins: 2 nan nan nan\nunits: \"ms\" \"\" \"\" \"\"\n");
  EXPECT_EQ(times_of(offered), (std::vector<double>{2, 2.25, 2.5}));
  EXPECT_EQ(offered.at(0).time_unit, "ms");
  EXPECT_EQ(times_of(offered_with("spacings: 4 1 1 1\n")), (std::vector<double>{0, 4, 8}));
  EXPECT_TRUE(times_of(offered_with("spacings: nan 1 1 1\n")).empty());
}

TEST(ImportTimes, OfMetaImage) {
  const TempFolder folder;
  write_file(folder / "v.mha",
             "ObjectType = Image\nNDims = 4\nBinaryData = True\nDimSize = 5 4 3 3\n"
             "ElementSpacing = 1 1 1 0.5\nOffset = 0 0 0 3\nElementType = MET_SHORT\n"
             "ElementDataFile = LOCAL\n" +
                 three_steps());
  const auto offered = offered_choices(folder / "v.mha");
  EXPECT_EQ(times_of(offered), (std::vector<double>{3, 3.5, 4}));
  EXPECT_EQ(offered.at(2).label, "time step 2 (4)");
}

TEST(ImportTimes, OfHdf5) {
  const std::filesystem::path folder =
      std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "tests/native/hdf5/conventions";
  const auto scales = offered_choices(folder / "times.h5");
  EXPECT_EQ(times_of(scales), (std::vector<double>{6, 12}));
  ASSERT_FALSE(scales.empty());
  EXPECT_EQ(scales[0].time_unit, "hours");
  EXPECT_EQ(times_of(offered_choices(folder / "steps.vtkhdf")), (std::vector<double>{0.25, 0.75}));
  EXPECT_TRUE(times_of(offered_choices(folder / "time.nc")).empty());
}

}  // namespace
}  // namespace isosplat::import
