#include "tests/native/dicom_files.h"

// Every assumption has a separate note, and no note contradicts the content of the file. If files
// are not volumes, the error names their kind.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_numbers;
using test::dicom_sequence;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;

constexpr const char* kNoOrientation = "the file has no orientation";
constexpr const char* kLetters = "stated by letters only";
constexpr const char* kNoPosition = "no position for its first frame";
constexpr const char* kNoDistance = "no distance between frames";
constexpr const char* kThickness = "the slice thickness";
constexpr const char* kOrder = "in the order of the file";
constexpr const char* kLocations = "have slice locations instead of positions";
constexpr const char* kNoSpacing = "have no pixel spacing";
constexpr const char* kRatio = "only the ratio of its pixel spacings";
constexpr const char* kDetector = "measured at the detector";

class DicomNotes : public ::testing::Test {
 protected:
  /// A file of frames that states nothing about their positions.
  DicomItem bare() const {
    DicomItem data = series_.common();
    data[0x00080018] = dicom_text("UI", "1.2.3.4.1");
    data[0x00280008] = dicom_text("IS", std::to_string(series_.size.z));
    std::vector<uint16_t> pixels;
    for (int z = 0; z < series_.size.z; ++z) {
      const auto some = series_.pixels(z);
      pixels.insert(pixels.end(), some.begin(), some.end());
    }
    data[0x7fe00010] = dicom_numbers("OW", pixels);
    return data;
  }

  OpenVolume open_data(const DicomItem& data) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    test::write_file(path, DicomWriter({}).file(data));
    return test::open(path);
  }

  /// Expects exactly these notes.
  void expect_notes(const DicomItem& data, const std::vector<std::string>& notes) {
    const OpenVolume volume = open_data(data);
    EXPECT_EQ(volume.notes.size(), notes.size()) << ::testing::PrintToString(volume.notes);
    for (const std::string& note : notes) test::expect_note(volume, note);
  }

  void expect_open_error(const DicomItem& data, const std::vector<std::string>& texts) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    test::write_file(path, DicomWriter({}).file(data));
    test::expect_open_error(path, texts);
  }

  BallSeries series_;
  const test::TempFolder folder_;

 private:
  int files_ = 0;
};

TEST_F(DicomNotes, EachAssumptionHasASeparateNote) {
  DicomItem data = bare();
  expect_notes(data, {kNoOrientation, kNoPosition, kNoDistance, kOrder, kNoSpacing});
  data[0x00200037] = series_.orientation_value();
  expect_notes(data, {kNoPosition, kNoDistance, kOrder, kNoSpacing});
  data[0x00200032] = series_.position_value(0);
  expect_notes(data, {kNoDistance, kOrder, kNoSpacing});
  data[0x00180088] = dicom_text("DS", "2");
  expect_notes(data, {kOrder, kNoSpacing});
  data[0x00280030] = series_.pixel_spacing_value();
  expect_notes(data, {kOrder});
  data[0x00540080] =
      dicom_numbers("US", std::vector<uint16_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  expect_notes(data, {});
  auto volume = open_data(data);
  test::expect_field(volume, series_);
}

TEST_F(DicomNotes, PropertiesThatAFileStatesElsewhereHaveNoNote) {
  DicomItem data = bare();
  data[0x00180050] = dicom_text("DS", "2");
  expect_notes(data, {kNoOrientation, kNoPosition, kThickness, kOrder, kNoSpacing});
  // The directions of rows and columns by letters: to the left, and to the feet.
  data[0x00200020] = dicom_text("CS", "L\\F");
  expect_notes(data, {kLetters, kNoPosition, kThickness, kOrder, kNoSpacing});
  auto volume = open_data(data);
  EXPECT_EQ(volume.source->header().grid.direction[7], -1);
  // Distance, thickness and pixel spacing in functional groups.
  data[0x00180050] = dicom_text("DS", "");
  data[0x52009229] = dicom_sequence(
      {{{0x00289110, dicom_sequence({{{0x00180050, dicom_text("DS", "3")},
                                      {0x00280030, series_.pixel_spacing_value()}}})}}});
  expect_notes(data, {kLetters, kNoPosition, "3 mm is assumed, the slice thickness", kOrder});
  data[0x52009229].items[0][0x00289110].items[0][0x00180088] = dicom_text("DS", "2");
  expect_notes(data, {kLetters, kNoPosition, kOrder});
  data.erase(0x52009229);
  // Slice locations of all frames.
  std::vector<double> locations;
  for (int z = 0; z < series_.size.z; ++z) locations.push_back(5 + 2.0 * z);
  data[0x00182005] = dicom_text("DS", test::dicom_decimals(locations));
  expect_notes(data, {kLetters, kNoPosition, kLocations, kNoSpacing});
  // Pixel spacing at the detector, only as a ratio, and in a region of an ultrasound image.
  data[0x00280034] = dicom_text("IS", "2\\1");
  expect_notes(data, {kLetters, kNoPosition, kLocations, kRatio});
  data[0x00181164] = series_.pixel_spacing_value();
  expect_notes(data, {kLetters, kNoPosition, kLocations, kDetector});
  data[0x00186011] = dicom_sequence({{{0x00186024, test::dicom_u16(3)},
                                      {0x00186026, test::dicom_u16(3)},
                                      {0x0018602c, dicom_numbers("FD", std::vector{0.125})},
                                      {0x0018602e, dicom_numbers("FD", std::vector{0.15})}}});
  expect_notes(data, {kLetters, kNoPosition, kLocations});
  volume = open_data(data);
  EXPECT_NEAR(length(volume.source->header().grid.spacing - series_.spacing), 0, 1e-9);
}

TEST_F(DicomNotes, FilesOfOneVolumeHaveTheNotesOfAll) {
  for (int z = 0; z < series_.size.z; ++z) {
    DicomItem data = series_.slice(z);
    data.erase(0x00280030);
    data[z == 0 ? 0x00181164 : 0x00280030] = series_.pixel_spacing_value();
    series_.write_slice(folder_, z, data);
  }
  auto volume = test::open(folder_.path());
  test::expect_field(volume, series_);
  test::expect_note(volume, kDetector);
}

TEST_F(DicomNotes, SlicesWithoutPositionsAreOrderedByTheirLocations) {
  for (int z = 0; z < series_.size.z; ++z) {
    DicomItem data = series_.slice(z);
    data.erase(0x00200032);
    data.erase(0x00200037);
    data[0x00200013] = dicom_text("IS", std::to_string((5 * z) % series_.size.z + 1));
    data[0x00201041] = dicom_text("DS", fmt::format("{}", 2.0 * z - 7));
    series_.write_slice(folder_, z, data);
  }
  test::expect_open_error(folder_.path(), {"no position", "slice locations with --allow-unplaced"});
  const auto volume = test::open(folder_.path(), test::allowing(Allowance::unplaced));
  test::expect_note(volume, "in the order of their slice locations, at a distance of 2 mm");
  test::expect_note(volume, kNoOrientation);
  const auto values = test::read_all(*volume.source);
  const auto last = series_.pixels(series_.size.z - 1);
  EXPECT_TRUE(std::equal(last.rbegin(), last.rend(), values.rbegin()));
}

TEST_F(DicomNotes, SlicesWithoutPositionsOrDistanceHaveTheirThickness) {
  for (const bool has_thickness : {true, false}) {
    for (int z = 0; z < series_.size.z; ++z) {
      DicomItem data = series_.slice(z);
      data.erase(0x00200032);
      if (has_thickness) data[0x00180050] = dicom_text("DS", "3");
      series_.write_slice(folder_, z, data);
    }
    const auto volume = test::open(folder_.path(), test::allowing(Allowance::unplaced));
    test::expect_note(volume, has_thickness ? "3 mm (the slice thickness)" : "1 mm (assumed");
  }
}

TEST_F(DicomNotes, TilesOfAWholeSlideImageAreNotSlices) {
  const DicomItem frames = bare();
  for (const char* type : {"TILED_FULL", "TILED_SPARSE"}) {
    for (const char* photometric : {"MONOCHROME2", "YBR_FULL_422"}) {
      DicomItem data = frames;
      data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.77.1.6");
      data[0x00080060] = dicom_text("CS", "SM");
      data[0x00209311] = dicom_text("CS", type);
      data[0x00280004] = dicom_text("CS", photometric);
      data[0x00480006] = dicom_numbers("UL", std::vector<uint32_t>{60});
      data[0x00480007] = dicom_numbers("UL", std::vector<uint32_t>{34});
      expect_open_error(data, {"12 tiles of 20 × 17 pixels", "whole-slide image of 60 × 34"});
      data[0x00480302] = dicom_numbers("UL", std::vector<uint32_t>{3});
      data[0x00480303] = dicom_numbers("UL", std::vector<uint32_t>{2});
      expect_open_error(data, {"in 2 focal planes", "of 3 optical paths"});
      // A segmentation of such an image is tiled as well.
      data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.66.4");
      expect_open_error(data, {"tiles"});
    }
  }
  test::expect_open_error(folder_.path(), {"tiles of 20 × 17 pixels"});
  series_.write(folder_);
  const auto volume = test::open(folder_.path());
  test::expect_note(volume, "which are whole-slide images");
}

TEST_F(DicomNotes, EnhancedFramesWithoutPositionsAreAFilm) {
  DicomItem data = bare();
  data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.12.1.1");
  data[0x00080060] = dicom_text("CS", "XA");
  std::vector<DicomItem> groups(static_cast<size_t>(series_.size.z));
  for (DicomItem& group : groups) group[0x00209111] = dicom_sequence({DicomItem{}});
  data[0x52009230] = dicom_sequence(groups);
  expect_open_error(data, {"frames of a film"});
}

TEST_F(DicomNotes, PartsOfAConcatenationAreOneVolume) {
  const auto part = [&](int number, const std::vector<int>& slices) {
    DicomItem data = series_.enhanced(slices);
    data[0x00080018] = dicom_text("UI", fmt::format("1.2.3.4.{}", number));
    data[0x00209161] = dicom_text("UI", "1.2.3.99");
    data[0x00209162] = test::dicom_u16(static_cast<uint16_t>(number));
    data[0x00209163] = test::dicom_u16(2);
    return data;
  };
  const auto first = folder_ / "a.dcm", second = folder_ / "b.dcm";
  test::write_file(first, DicomWriter({}).file(part(1, {0, 1, 2, 3, 4, 5})));
  test::expect_open_error(first, {"1 of 2 parts of the image (Concatenation) are missing"});
  test::expect_open_error(folder_.path(), {"1 of 2 parts"});
  const auto allowed = test::open(first, test::allowing(Allowance::gaps));
  test::expect_note(allowed, "are missing");
  test::write_file(second, DicomWriter({}).file(part(2, {6, 7, 8, 9, 10, 11})));
  auto volume = test::open(folder_.path());
  test::expect_field(volume, series_);
  EXPECT_EQ(volume.source->header().grid.voxels.z, series_.size.z);
}

}  // namespace
}  // namespace isosplat::import
