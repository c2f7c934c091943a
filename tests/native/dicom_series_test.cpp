#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <numbers>

#include "native/builder/builder.h"
#include "shared/import/dicom/order.h"
#include "tests/native/dicom_files.h"

// Folders with a file per slice.
namespace isosplat::import {
namespace {

using test::allowing;
using test::BallSeries;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;
using test::expect_field;
using test::expect_note;
using test::expect_open_error;
using test::open;
using test::TempFolder;
using test::write_file;

ImportOptions with_step(int64_t step) {
  ImportOptions options;
  options.time_step = step;
  return options;
}

ImportOptions with_series(const std::string& series) {
  ImportOptions options;
  options.series = series;
  return options;
}

/// Rotates the series by three angles, so that its slices are not parallel to a patient plane.
void turn(BallSeries& series, double a, double b, double c) {
  const auto turned = [&](Vec3d v) {
    v = {v.x * std::cos(a) - v.y * std::sin(a), v.x * std::sin(a) + v.y * std::cos(a), v.z};
    v = {v.x, v.y * std::cos(b) - v.z * std::sin(b), v.y * std::sin(b) + v.z * std::cos(b)};
    return Vec3d{v.x * std::cos(c) + v.z * std::sin(c), v.y, v.z * std::cos(c) - v.x * std::sin(c)};
  };
  series.row = turned(series.row);
  series.column = turned(series.column);
}

TEST(DicomSeries, EveryVoxelHasThePositionOfItsSliceInAnyOrientation) {
  const std::pair<Vec3d, Vec3d> planes[] = {
      {{1, 0, 0}, {0, 1, 0}},  {{1, 0, 0}, {0, 0, -1}}, {{0, 1, 0}, {0, 0, -1}},
      {{-1, 0, 0}, {0, 1, 0}}, {{0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}},
  };
  for (const auto& [row, column] : planes) {
    for (const double angle : {0.0, 0.4}) {
      const TempFolder folder;
      BallSeries series;
      series.row = row;
      series.column = column;
      turn(series, angle, -angle / 2, angle / 3);
      series.write(folder);
      auto volume = open(folder.path());
      expect_field(volume, series);
      EXPECT_TRUE(volume.notes.empty()) << ::testing::PrintToString(volume.notes);
      EXPECT_NEAR(length(volume.source->header().grid.spacing - series.spacing), 0, 1e-6);
    }
  }
}

TEST(DicomSeries, RescalesSignedAndUnsignedPixels) {
  struct Case {
    bool is_signed;
    uint16_t stored;
    double slope, intercept, add;
    VoxelType type;
  };
  const Case cases[] = {
      {false, 12, 1, 0, 0, VoxelType::u16},        {false, 12, 1, -1024, -1024, VoxelType::i16},
      {true, 16, 1, -1024, -1024, VoxelType::i32}, {true, 16, 1, 0, -500, VoxelType::i16},
      {true, 13, 1, 0, -500, VoxelType::i16},      {false, 16, 2, -10, -10, VoxelType::i32},
  };
  for (const Case& c : cases) {
    const TempFolder folder;
    BallSeries series;
    series.is_signed = c.is_signed;
    series.stored = c.stored;
    series.slope = c.slope;
    series.intercept = c.intercept;
    series.add = c.add;
    series.write(folder);
    auto volume = open(folder.path());
    expect_field(volume, series, c.slope);
    EXPECT_STREQ(voxel_type_name(volume.source->header().type), voxel_type_name(c.type));
  }
}

TEST(DicomSeries, PixelsStayIntegersWithAnySlope) {
  const TempFolder folder;
  BallSeries series;
  series.stored = 12;
  series.slope = 2.0078;
  series.intercept = -1024;
  series.add = -1024;
  series.write(folder);
  auto volume = open(folder.path());
  expect_field(volume, series, series.slope);
  const VolumeHeader& header = volume.source->header();
  EXPECT_EQ(header.type, VoxelType::u16);
  EXPECT_EQ(header.slope, 2.0078);
  EXPECT_EQ(header.intercept, -1024);
}

TEST(DicomSeries, SlopesThatDifferFromSliceToSliceGiveEachSliceItsValues) {
  const TempFolder folder;
  BallSeries series;
  series.stored = 16;
  for (int z = 0; z < series.size.z; ++z) {
    series.slope = 0.125 + 0.03 * z;  // as in PET
    series.write_slice(folder, z, series.slice(z));
  }
  auto volume = open(folder.path());
  expect_field(volume, series, 0.5);
  expect_note(volume, "different slopes or intercepts");
}

TEST(DicomSeries, BitsBesideTheStoredOnesAreNotValues) {
  const TempFolder folder;
  BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    std::vector<uint16_t> pixels = series.pixels(z);
    for (uint16_t& pixel : pixels) pixel |= 0x9000;  // bits of an overlay
    data[0x7fe00010] = test::dicom_numbers("OW", pixels);
    series.write_slice(folder, z, data);
  }
  auto volume = open(folder.path());
  expect_field(volume, series);
}

TEST(DicomSeries, AMissingSliceIsAnErrorOrIsInterpolated) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    if (z != 4 && z != 7) series.write_slice(folder, z, series.slice(z));
  }
  expect_open_error(folder.path(), {"missing or unevenly spaced", "2 to 4 mm", "--allow-gaps"});
  auto volume = open(folder.path(), allowing(Allowance::gaps));
  expect_note(volume, "2 of 12 slices are interpolated");
  EXPECT_EQ(volume.source->header().grid.voxels, series.size);
  // Existing slices are exact, the others are the mean of their neighbours.
  const auto values = test::read_all(*volume.source);
  const size_t slice = static_cast<size_t>(series.size.x) * static_cast<size_t>(series.size.y);
  const auto at = [&](int z) { return series.pixels(z); };
  for (size_t i = 0; i < slice; ++i) {
    EXPECT_EQ(values[5 * slice + i], at(5)[i]);
    EXPECT_NEAR(values[4 * slice + i], (at(3)[i] + at(5)[i]) / 2.0, 0.5);
  }
}

TEST(DicomSeries, RoundedPositionsAreNotGaps) {
  const TempFolder folder;
  BallSeries series;
  series.spacing.z = 0.625;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    const Vec3d p = series.position(z);
    data[0x00200032] = dicom_text("DS", fmt::format("{}\\{}\\{:.1f}", p.x, p.y, p.z));
    series.write_slice(folder, z, data);
  }
  auto volume = open(folder.path());
  expect_field(volume, series, 40);
  EXPECT_NEAR(volume.source->header().grid.spacing.z, 0.625, 0.01);
}

TEST(DicomSeries, UnevenSpacingIsAnError) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    const Vec3d p = series.position(z);
    data[0x00200032] = dicom_text("DS", fmt::format("{}\\{}\\{}", p.x, p.y, 2 * z + 0.02 * z * z));
    series.write_slice(folder, z, data);
  }
  expect_open_error(folder.path(), {"unevenly spaced", "--allow-gaps"});
}

TEST(DicomSeries, TwoOrientationsInASeriesNeedAChoice) {
  const TempFolder folder;
  BallSeries axial, tilted;
  axial.size.z = tilted.size.z = 10;
  turn(tilted, 0, 29 * std::numbers::pi / 180, 0);
  tilted.first_instance = 11;
  axial.write(folder);
  tilted.write(folder);
  expect_open_error(folder.path(), {"found 2 kinds", "--series 1: ", "--series 2: ", "axial"});
  int found_axial = 0;
  for (const char* number : {"1", "2"}) {
    auto volume = open(folder.path(), with_series(number));
    const bool is_axial = volume.source->header().grid.direction[8] > 0.999;
    found_axial += is_axial;
    expect_field(volume, is_axial ? axial : tilted);
  }
  EXPECT_EQ(found_axial, 1);
  expect_open_error(folder.path(), {"--series"}, with_series("3"));
  expect_open_error(folder.path(), {"--series"}, with_series("1.2.3.4"));
}

TEST(DicomSeries, TwoPixelSpacingsSizesOrPhotometricInterpretationsNeedAChoice) {
  for (const int what : {0, 1, 2}) {
    const TempFolder folder;
    BallSeries first, second;
    first.size.z = second.size.z = 6;
    second.first_instance = 20;
    second.centre = {0, 0, 12};
    if (what == 0) second.spacing.x = 1.3;
    if (what == 1) second.size.x = 18;
    first.write(folder);
    for (int z = 0; z < second.size.z; ++z) {
      DicomItem data = second.slice(z);
      if (what == 2) data[0x00280004] = dicom_text("CS", "MONOCHROME1");
      second.write_slice(folder, z, data);
    }
    expect_open_error(folder.path(), {"found 2 kinds", "--series 2: "});
  }
}

TEST(DicomSeries, TheLargestSeriesIsReadAndTheOthersAreNoted) {
  const TempFolder folder;
  BallSeries scan, scout;
  scout.uid = "1.2.3.9";
  scout.size = {40, 30, 2};
  scan.write(folder);
  scout.write(folder);
  auto volume = open(folder.path());
  expect_field(volume, scan);
  expect_note(volume, "--series 2: CT, 2 axial slices of 40 × 30");
  auto other = open(folder.path(), with_series("1.2.3.9"));
  EXPECT_EQ(other.source->header().grid.voxels, scout.size);
}

TEST(DicomSeries, FilesThatAreNotSlicesAreIgnoredAndNoted) {
  const TempFolder folder;
  const BallSeries scan;
  scan.write(folder);
  write_file(folder / "notes.txt", "not an image");
  BallSeries shot;
  shot.uid = "1.2.3.8";
  shot.size = {60, 50, 2};
  for (int z = 0; z < 2; ++z) {
    DicomItem data = shot.slice(z);
    data[0x00280002] = test::dicom_u16(3);
    data[0x00280004] = dicom_text("CS", "RGB");
    data[0x7fe00010] = test::dicom_numbers("OB", std::vector<uint8_t>(60 * 50 * 3));
    shot.write_slice(folder, z, data);
  }
  DicomItem report = scan.slice(0);
  report[0x00080016] = dicom_text("UI", "1.2.840.10008.1.3.10");
  report.erase(0x7fe00010);
  write_file(folder / "DICOMDIR", DicomWriter({}).file(report));
  DicomItem localizer = scan.slice(0);
  localizer[0x00080008] = dicom_text("CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
  localizer[0x00080018] = dicom_text("UI", "1.2.3.4.5.6");
  localizer[0x00200037] = dicom_text("DS", "0\\1\\0\\0\\0\\-1");
  write_file(folder / "scout.dcm", DicomWriter({}).file(localizer));
  auto volume = open(folder.path());
  expect_field(volume, scan);
  expect_note(volume, "1 file is ignored, which is not DICOM (notes.txt)");
  expect_note(volume, "1 file is ignored, which has no pixels (DICOMDIR)");
  expect_note(volume, "2 files are ignored, which are colour pictures");
  expect_note(volume, "1 localizer image is ignored");
}

TEST(DicomSeries, TiffScreenshotsDoNotReplaceTheScan) {
  const TempFolder folder;
  const BallSeries scan;
  scan.write(folder);
  for (const char* name : {"shot1.tif", "shot2.tif"}) {
    write_file(folder / name, std::string("II*\0", 4) + std::string(3000, 'x'));
  }
  auto volume = open(folder.path());
  expect_field(volume, scan);
  expect_note(volume, "2 files are ignored, which are not DICOM (shot1.tif, shot2.tif)");
}

TEST(DicomSeries, DamagedFilesAreErrorsOrIgnored) {
  for (const bool is_empty : {false, true}) {
    const TempFolder folder;
    const BallSeries series;
    series.write(folder);
    const std::string whole = test::read_file(folder / series.file_name(5));
    write_file(folder / series.file_name(5), is_empty ? "" : whole.substr(0, 300));
    expect_open_error(folder.path(), {series.file_name(5), "--allow-gaps"});
    auto volume = open(folder.path(), allowing(Allowance::gaps));
    expect_note(volume, "1 file is ignored, which cannot be read");
    expect_note(volume, "1 of 12 slices are interpolated");
  }
}

TEST(DicomSeries, ATruncatedSliceIsAnErrorOrHasAbsentVoxels) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  const std::string whole = test::read_file(folder / series.file_name(6));
  write_file(folder / series.file_name(6), whole.substr(0, whole.size() - 101));
  expect_open_error(folder.path(),
                    {series.file_name(6), "end before their last pixel", "--allow-truncated"});
  auto volume = open(folder.path(), allowing(Allowance::truncated));
  expect_note(volume, "end before their last pixel");
  const auto values = test::read_all(*volume.source);
  const size_t slice = static_cast<size_t>(series.size.x) * static_cast<size_t>(series.size.y);
  const auto pixels = series.pixels(6);
  for (size_t i = 0; i < slice; ++i) {
    if (i < slice - 51) {
      EXPECT_EQ(values[6 * slice + i], pixels[i]);
    } else {
      EXPECT_TRUE(std::isnan(values[6 * slice + i]));
    }
  }
}

TEST(DicomSeries, PixelsForAnotherFrameAreAnErrorOrIgnored) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  DicomItem data = series.slice(3);
  auto pixels = series.pixels(3);
  pixels.insert(pixels.end(), pixels.begin(), pixels.end());
  data[0x7fe00010] = test::dicom_numbers("OW", pixels);
  series.write_slice(folder, 3, data);
  expect_open_error(folder.path(), {"more pixels than their header says", "--allow-surplus"});
  auto volume = open(folder.path(), allowing(Allowance::surplus));
  expect_field(volume, series);
}

TEST(DicomSeries, HasTheFrameOfReferenceOfItsSlicesWithoutTheUid) {
  const auto frame_of = [](const std::string& uid) {
    const TempFolder folder;
    const BallSeries series;
    series.write(folder);
    for (int i = 0; i < series.size.z; ++i) {
      DicomItem data = series.slice(i);
      if (!uid.empty()) data[0x00200052] = test::dicom_text("UI", uid);
      series.write_slice(folder, i, data);
    }
    return open(folder.path()).source->header().frame_of_reference;
  };
  EXPECT_EQ(frame_of(""), "");
  const std::string frame = frame_of("1.2.3.4");
  EXPECT_TRUE(frame.starts_with("dicom-")) << frame;
  EXPECT_EQ(frame.size(), 22u);
  EXPECT_EQ(frame_of("1.2.3.4"), frame);
  EXPECT_NE(frame_of("1.2.3.5"), frame);
}

TEST(DicomSeries, DifferentFramesOfReferenceAndSubfoldersAreNoted) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  EXPECT_TRUE(open(folder.path()).notes.empty());
  DicomItem data = series.slice(3);
  data[0x00200052] = test::dicom_text("UI", "1.2.3.4");
  series.write_slice(folder, 3, data);
  std::filesystem::create_directory(folder / "more");
  auto volume = open(folder.path());
  expect_note(volume, "2 frames of reference");
  EXPECT_EQ(volume.source->header().frame_of_reference, "");
  expect_note(volume, "1 subfolder is not read, such as more");
  expect_field(volume, series);
}

// If there are enough extra pixels for another row, the number of rows or columns is wrong. Fewer
// extra bytes are padding.
TEST(DicomSeries, PixelsForAnotherRowAreAnErrorAndFewerBytesArePadding) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  DicomItem data = series.slice(3);
  auto pixels = series.pixels(3);
  const auto write_surplus = [&](int32_t count) {
    auto more = pixels;
    more.insert(more.end(), pixels.begin(), pixels.begin() + count);
    data[0x7fe00010] = test::dicom_numbers("OW", more);
    series.write_slice(folder, 3, data);
  };
  write_surplus(series.size.x - 1);
  auto padded = open(folder.path());
  expect_field(padded, series);
  write_surplus(series.size.x);
  expect_open_error(folder.path(), {"more pixels than their header says", "--allow-surplus"});
}

TEST(DicomSeries, TimePointsAreDistinguishedByAttributes) {
  struct Case {
    uint32_t tag;
    const char* vr;
    std::vector<std::string> values;  // in the order of the steps
    const char* name;
  };
  const Case cases[] = {
      {0x00200100, "IS", {"1", "2", "10"}, "temporal position"},
      {0x00181060, "DS", {"0", "95.5", "200"}, "trigger time"},
      {0x00180086, "IS", {"1", "2", "3"}, "echo"},
      {0x00080032, "TM", {"101500", "101501.5", "101510"}, "acquisition time"},
      {0x00200012, "IS", {"2", "9", "11"}, "acquisition number"},
      {0x00080008,
       "CS",
       {"DERIVED\\PRIMARY\\F", "DERIVED\\PRIMARY\\M", "DERIVED\\PRIMARY\\W"},
       "image type"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const TempFolder folder;
    BallSeries steps[3];
    for (int t = 0; t < 3; ++t) {
      steps[t].add = 100 * t;
      steps[t].first_instance = 1 + 100 * ((t + 1) % 3);  // not in the order of time
      for (int z = 0; z < steps[t].size.z; ++z) {
        DicomItem data = steps[t].slice(z);
        data[c.tag] = dicom_text(c.vr, c.values[static_cast<size_t>(t)]);
        steps[t].write_slice(folder, z, data);
      }
    }
    expect_open_error(folder.path(), {"found 3 at the same position", c.name, "--time-step 2"});
    const auto offered = test::offered_choices(folder.path());
    ASSERT_EQ(offered.size(), 3u);
    const bool is_time = std::string(c.name) == "trigger time";
    EXPECT_EQ(offered[1].time, is_time ? std::optional(95.5) : std::nullopt);
    EXPECT_EQ(offered[1].time_unit, is_time ? "ms" : "");
    for (int t = 0; t < 3; ++t) {
      auto volume = open(folder.path(), with_step(t));
      expect_field(volume, steps[t]);
      expect_note(volume, c.name);
    }
    expect_open_error(folder.path(), {"--time-step"}, with_step(3));
  }
}

TEST(DicomSeries, TimePointsAreDistinguishedByTwoAttributes) {
  const TempFolder folder;
  std::vector<BallSeries> steps;
  for (int t = 0; t < 4; ++t) {
    BallSeries series;
    series.add = 100 * t;
    series.first_instance = 1 + 100 * t;
    for (int z = 0; z < series.size.z; ++z) {
      DicomItem data = series.slice(z);
      data[0x00200100] = dicom_text("IS", std::to_string(t / 2));
      data[0x00180086] = dicom_text("IS", std::to_string(t % 2));
      series.write_slice(folder, z, data);
    }
    steps.push_back(series);
  }
  for (int t = 0; t < 4; ++t) {
    auto volume = open(folder.path(), with_step(t));
    expect_field(volume, steps[static_cast<size_t>(t)]);
    expect_note(volume, "temporal position and echo");
  }
}

TEST(DicomSeries, TimePointsAreDistinguishedByInstanceNumbersLast) {
  for (const bool place_by_place : {false, true}) {
    const TempFolder folder;
    BallSeries steps[3];
    for (int t = 0; t < 3; ++t) {
      steps[t].add = 100 * t;
      steps[t].first_instance = 1 + 100 * t;
      for (int z = 0; z < steps[t].size.z; ++z) {
        DicomItem data = steps[t].slice(z);
        if (place_by_place) data[0x00200013] = dicom_text("IS", std::to_string(10 * z + t));
        steps[t].write_slice(folder, z, data);
      }
    }
    for (int t = 0; t < 3; ++t) {
      auto volume = open(folder.path(), with_step(t));
      expect_field(volume, steps[t]);
    }
  }
}

TEST(DicomSeries, SlicesAtTheSamePositionWithoutAnAttributeAreAnError) {
  const TempFolder folder;
  BallSeries series, again;
  again.first_instance = 101;
  again.add = 100;
  series.write(folder);
  again.write_slice(folder, 4, again.slice(4));  // one slice of another volume
  expect_open_error(folder.path(), {"at the same position", "a separate folder"});
}

TEST(DicomSeries, ATimePointWithAMissingSliceIsAnError) {
  const TempFolder folder;
  BallSeries steps[2];
  for (int t = 0; t < 2; ++t) {
    steps[t].add = 100 * t;
    steps[t].first_instance = 1 + 100 * t;
    for (int z = 0; z < steps[t].size.z; ++z) {
      DicomItem data = steps[t].slice(z);
      data[0x00200100] = dicom_text("IS", std::to_string(t + 1));
      if (t == 0 || z != 11) steps[t].write_slice(folder, z, data);
    }
  }
  auto whole = open(folder.path(), with_step(0));
  expect_field(whole, steps[0]);
  expect_open_error(folder.path(), {"1 of 12 slices are missing from volume 1", "--allow-gaps"},
                    with_step(1));
}

TEST(DicomSeries, ATimePointOfOneSliceIsAnErrorWithAllAllowances) {
  const TempFolder folder;
  BallSeries series;
  series.size.z = 2;
  for (int t = 0; t < 2; ++t) {
    for (int z = 0; z < 2 - t; ++z) {
      series.first_instance = 1 + 10 * t;
      DicomItem data = series.slice(z);
      data[0x00200100] = dicom_text("IS", std::to_string(t));
      series.write_slice(folder, z, data);
    }
  }
  open(folder.path(), with_step(0));
  ImportOptions options = with_step(1);
  options.allowed.add(Allowance::gaps);
  expect_open_error(folder.path(), {"1 of 2 slices are missing from volume 1", "no isosurface"},
                    options);
}

TEST(DicomSeries, OfTwoGapsTheSmallerIsTheSliceDistance) {
  for (const int missing : {1, 2}) {
    const TempFolder folder;
    BallSeries series;
    series.size.z = 4;
    series.centre = {0, 0, 5};
    series.write(folder);
    std::filesystem::remove(folder / series.file_name(missing));
    auto volume = open(folder.path(), allowing(Allowance::gaps));
    EXPECT_EQ(volume.source->header().grid.voxels.z, 4);
    expect_note(volume, "1 of 4 slices are interpolated");
  }
}

TEST(DicomSeries, DuplicateFilesAreIgnored) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  std::filesystem::copy(folder / series.file_name(3), folder / "copy.dcm");
  auto volume = open(folder.path());
  expect_field(volume, series);
  expect_note(volume, "1 slice is duplicated");
  DicomItem other = series.slice(3);
  other[0x00200032] = series.position_value(4);
  write_file(folder / "copy.dcm", DicomWriter({}).file(other));
  expect_open_error(folder.path(), {"SOP Instance UID"});
}

TEST(DicomSeries, AGantryTiltShearsTheVolumeAndIsNoted) {
  const TempFolder folder;
  BallSeries series;
  const double tilt = 15 * std::numbers::pi / 180;
  series.step = Vec3d{0, std::sin(tilt), std::cos(tilt)} * 2;
  series.write(folder);
  auto volume = open(folder.path());
  expect_field(volume, series);
  expect_note(volume, "tilted by 15.0°");

  // The geometry of the header, from which the grid is computed, gives every slice the position
  // that its file states.
  dicom::Collection collection;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const auto elements = dicom::read_elements(entry.path());
    ASSERT_TRUE(elements);
    ASSERT_TRUE(dicom::add_frames(*elements, entry.path(), collection));
  }
  std::vector<std::string> notes;
  const auto stack = dicom::choose_stack(collection, folder.path(), {}, notes);
  ASSERT_TRUE(stack);
  const auto arranged = dicom::arrange(collection, *stack, folder.path(), {}, notes);
  ASSERT_TRUE(arranged);
  const HeaderGeometry& geometry = arranged->geometry;
  const Vec3d axis{geometry.direction[2], geometry.direction[5], geometry.direction[8]};
  for (int z = 0; z < series.size.z; ++z) {
    const Vec3d at = geometry.origin + axis * (geometry.spacing.z * z);
    EXPECT_LT(length(at - series.position(z)), 1e-6);
  }
}

TEST(DicomSeries, IrregularlyShiftedSlicesAreAnError) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    const Vec3d p = series.position(z);
    data[0x00200032] =
        dicom_text("DS", fmt::format("{}\\{}\\{}", p.x + (z == 5 ? 3 : 0), p.y, p.z));
    series.write_slice(folder, z, data);
  }
  expect_open_error(folder.path(), {"off that line"});
}

TEST(DicomSeries, Monochrome1KeepsItsValuesAndIsNoted) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x00280004] = dicom_text("CS", "MONOCHROME1");
    series.write_slice(folder, z, data);
  }
  auto volume = open(folder.path());
  expect_field(volume, series);
  expect_note(volume, "MONOCHROME1");
}

TEST(DicomSeries, SlicesWithoutPositionsAreStackedOnlyIfAllowed) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data.erase(0x00200032);
    data[0x00180088] = dicom_text("DS", "2");
    series.write_slice(folder, z, data);
  }
  expect_open_error(folder.path(), {"have no position", "--allow-unplaced"});
  auto volume = open(folder.path(), allowing(Allowance::unplaced));
  expect_note(volume, "in the order of their instance numbers, at a distance of 2 mm");
  const auto values = test::read_all(*volume.source);
  const auto last = series.pixels(series.size.z - 1);
  EXPECT_TRUE(std::equal(last.rbegin(), last.rend(), values.rbegin()));
}

TEST(DicomSeries, ASpacingThatPositionsContradictIsNoted) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x00180050] = dicom_text("DS", "5");  // the thickness is arbitrary
    data[0x00180088] = dicom_text("DS", "1");
    series.write_slice(folder, z, data);
  }
  auto volume = open(folder.path());
  expect_field(volume, series);
  ASSERT_EQ(volume.notes.size(), 1u);
  expect_note(volume, "the positions are used");
}

TEST(DicomSeries, LookupTablesAreRefused) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x00283000] = test::dicom_sequence({{{0x00283002, test::dicom_u16(1)}}});
    series.write_slice(folder, z, data);
  }
  expect_open_error(folder.path(), {"lookup table"});
}

/// Writes slices with a sparse private element of `hole` bytes each.
void write_with_private_elements(const TempFolder& folder, const BallSeries& series, size_t hole) {
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    const DicomItem pixels{{0x7fe00010, data[0x7fe00010]}};
    data.erase(0x7fe00010);
    const auto length = static_cast<uint32_t>(hole);
    const std::string head = DicomWriter({}).file(data) + std::string("\x29\x00\x10\x10OB\0\0", 8) +
                             std::string(reinterpret_cast<const char*>(&length), 4);
    const std::string tail = DicomWriter({}).item(pixels);
    const int file = ::open((folder / series.file_name(z)).c_str(), O_WRONLY | O_CREAT, 0600);
    ASSERT_GE(file, 0);
    EXPECT_EQ(::pwrite(file, head.data(), head.size(), 0), static_cast<ssize_t>(head.size()));
    EXPECT_EQ(::pwrite(file, tail.data(), tail.size(), static_cast<off_t>(head.size() + hole)),
              static_cast<ssize_t>(tail.size()));
    ::close(file);
  }
}

TEST(DicomSeries, LargePrivateElementsLoseNoSliceAndUseNoMemory) {
  const TempFolder folder;
  BallSeries series;
  series.size = {8, 8, 3000};
  series.spacing = {2, 2, 0.008};
  write_with_private_elements(folder, series, 1 << 20);
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  unsigned long long pages = 0;
  FILE* statm = std::fopen("/proc/self/statm", "r");
  ASSERT_EQ(std::fscanf(statm, "%llu", &pages), 1);
  std::fclose(statm);
#ifndef __SANITIZE_ADDRESS__
  // 3 GB of private elements; 64 MiB suffice.
  const rlimit least{pages * static_cast<rlim_t>(getpagesize()) + (64 << 20), before.rlim_max};
  setrlimit(RLIMIT_AS, &least);
#endif
  auto volume = open(folder.path());
  setrlimit(RLIMIT_AS, &before);
  expect_field(volume, series);
  EXPECT_EQ(volume.source->header().grid.voxels.z, 3000);

  BuildOptions build;
  build.memory_bytes = uint64_t{1} << 30;
#ifndef __SANITIZE_ADDRESS__
  const rlimit gibibyte{pages * static_cast<rlim_t>(getpagesize()) + (1 << 30), before.rlim_max};
  setrlimit(RLIMIT_AS, &gibibyte);
#endif
  const auto report = build_store_file(*volume.source, folder / "a.isosplat", build);
  setrlimit(RLIMIT_AS, &before);
  ASSERT_TRUE(report) << report.error().message;
}

}  // namespace
}  // namespace isosplat::import
