#include <algorithm>
#include <numeric>

#include "tests/native/dicom_files.h"

// Files with several frames.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_decimals;
using test::dicom_numbers;
using test::dicom_sequence;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;
using test::expect_field;
using test::TempFolder;
using test::write_file;

class DicomFrames : public ::testing::Test {
 protected:
  /// Opens one file with these elements.
  Result<OpenVolume> open_data(const DicomItem& data, const ImportOptions& options = {},
                               const test::DicomSyntax& syntax = {}) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    write_file(path, DicomWriter(syntax).file(data));
    return open_volume(path, options);
  }

  void expect_open_error(const DicomItem& data, const std::vector<std::string>& texts) {
    const auto volume = open_data(data);
    ASSERT_FALSE(volume) << "expected an error that contains \"" << texts[0] << "\"";
    for (const std::string& text : texts) {
      EXPECT_NE(volume.error().message.find(text), std::string::npos) << volume.error().message;
    }
  }

  void expect_series(const DicomItem& data, const BallSeries& series,
                     const ImportOptions& options = {}, const test::DicomSyntax& syntax = {}) {
    auto volume = open_data(data, options, syntax);
    ASSERT_TRUE(volume) << volume.error().message;
    expect_field(*volume, series);
    EXPECT_EQ(volume->source->header().grid.voxels.z, series.size.z);
  }

  void expect_note(const DicomItem& data, const std::string& text) {
    const auto volume = open_data(data);
    ASSERT_TRUE(volume) << volume.error().message;
    const bool is_there =
        std::any_of(volume->notes.begin(), volume->notes.end(),
                    [&](const std::string& note) { return note.find(text) != std::string::npos; });
    EXPECT_TRUE(is_there) << ::testing::PrintToString(volume->notes);
  }

 private:
  TempFolder folder_;
  int files_ = 0;
};

std::vector<int> frames_of(const BallSeries& series) {
  std::vector<int> order(static_cast<size_t>(series.size.z));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

std::vector<uint16_t> all_pixels(const BallSeries& series, const std::vector<int>& order) {
  std::vector<uint16_t> all;
  for (const int z : order) {
    const auto some = series.pixels(z);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

TEST_F(DicomFrames, EnhancedFramesKeepTheirPositionsInAnyOrder) {
  BallSeries series;
  series.intercept = series.add = -1000;
  std::vector<int> order = frames_of(series);
  expect_series(series.enhanced(order), series);
  std::reverse(order.begin(), order.end());  // against row × column
  expect_series(series.enhanced(order), series);
  order = {5, 0, 11, 3, 7, 1, 9, 2, 10, 4, 8, 6};
  expect_series(series.enhanced(order), series);
}

TEST_F(DicomFrames, SequencesWithUndefinedLengthsAndOtherSyntaxesAreTheSame) {
  const BallSeries series;
  const DicomItem data = series.enhanced(frames_of(series));
  for (test::DicomSyntax syntax : {test::DicomSyntax{}, test::implicit_little(),
                                   test::explicit_big(), test::deflated_little()}) {
    for (const bool undefined : {false, true}) {
      syntax.undefined_lengths = undefined;
      SCOPED_TRACE(syntax.uid);
      expect_series(data, series, {}, syntax);
    }
  }
}

TEST_F(DicomFrames, StacksOfDifferentOrientationAreChosen) {
  BallSeries axial, coronal;
  coronal.column = {0, 0, -1};
  DicomItem data = axial.enhanced(frames_of(axial));
  DicomItem other = coronal.enhanced(frames_of(coronal));
  for (auto [stack, item] : {std::pair{"1", &data}, std::pair{"2", &other}}) {
    const BallSeries& series = stack[0] == '1' ? axial : coronal;
    for (DicomItem& frame : (*item)[0x52009230].items) {
      frame[0x00209116] = dicom_sequence({{{0x00200037, series.orientation_value()}}});
      frame[0x00209111] = dicom_sequence({{{0x00209056, dicom_text("SH", stack)}}});
    }
  }
  data[0x52009229].items[0].erase(0x00209116);
  auto& frames = data[0x52009230].items;
  frames.insert(frames.end(), other[0x52009230].items.begin(), other[0x52009230].items.end());
  data[0x00280008] = dicom_text("IS", "24");
  auto pixels = all_pixels(axial, frames_of(axial));
  const auto more = all_pixels(coronal, frames_of(coronal));
  pixels.insert(pixels.end(), more.begin(), more.end());
  data[0x7fe00010] = dicom_numbers("OW", pixels);
  expect_open_error(data, {"found 2 kinds", "stack 1", "stack 2", "coronal"});
  for (const char* which : {"1", "2"}) {
    ImportOptions options;
    options.series = which;
    auto volume = open_data(data, options);
    ASSERT_TRUE(volume) << volume.error().message;
    expect_field(*volume,
                 std::abs(volume->source->header().grid.direction[8]) > 0.9 ? axial : coronal);
  }
}

TEST_F(DicomFrames, TimesInAFileAreDistinguished) {
  BallSeries steps[2];
  steps[1].add = 100;
  DicomItem data = steps[0].enhanced(frames_of(steps[0]));
  std::vector<DicomItem> frames;
  std::vector<uint16_t> pixels;
  for (int z = 0; z < steps[0].size.z; ++z) {
    for (const int t : {1, 0}) {
      frames.push_back(
          {{0x00209113, dicom_sequence({{{0x00200032, steps[0].position_value(z)}}})},
           {0x00209111,
            dicom_sequence({{{0x00209128, dicom_numbers("UL", std::vector<uint32_t>{
                                                                  static_cast<uint32_t>(t)})}}})}});
      const auto some = steps[t].pixels(z);
      pixels.insert(pixels.end(), some.begin(), some.end());
    }
  }
  data[0x52009230] = dicom_sequence(frames);
  data[0x00280008] = dicom_text("IS", "24");
  data[0x7fe00010] = dicom_numbers("OW", pixels);
  expect_open_error(data, {"found 2 at the same position", "temporal position"});
  for (int t = 0; t < 2; ++t) {
    ImportOptions options;
    options.time_step = t;
    expect_series(data, steps[t], options);
  }
}

/// A dose grid: frame offsets, 32-bit pixels with a scaling.
DicomItem dose(const BallSeries& series, const std::vector<double>& offsets, double scaling) {
  DicomItem data = series.slice(0);
  data[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.481.2");
  data[0x00080060] = dicom_text("CS", "RTDOSE");
  data[0x00280008] = dicom_text("IS", std::to_string(series.size.z));
  data[0x00280100] = test::dicom_u16(32);
  data[0x00280101] = test::dicom_u16(32);
  data[0x00280102] = test::dicom_u16(31);
  data[0x3004000c] = dicom_text("DS", dicom_decimals(offsets));
  data[0x3004000e] = dicom_text("DS", fmt::format("{}", scaling));
  std::vector<uint32_t> pixels;
  for (int z = 0; z < series.size.z; ++z) {
    for (int y = 0; y < series.size.y; ++y) {
      for (int x = 0; x < series.size.x; ++x) {
        const Vec3d world = series.position(z) + series.row * (series.spacing.x * x) +
                            series.column * (series.spacing.y * y);
        pixels.push_back(static_cast<uint32_t>(std::round(series.value(world) / scaling)));
      }
    }
  }
  data[0x7fe00010] = dicom_numbers("OW", pixels);
  return data;
}

TEST_F(DicomFrames, DoseGridsHaveTheirScalingAndBothKindsOfOffsets) {
  BallSeries series;
  std::vector<double> relative, absolute;
  for (int z = 0; z < series.size.z; ++z) {
    relative.push_back(2.0 * z);
    absolute.push_back(series.position(z).z);
  }
  auto volume = open_data(dose(series, relative, 0.001));
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series, 0.001);
  volume = open_data(dose(series, absolute, 0.25));
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series, 0.25);

  // Along the normal, which points down here, and as decreasing z coordinates.
  series.column = {0, -1, 0};
  volume = open_data(dose(series, relative, 0.01));
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series, 0.01);
  for (int z = 0; z < series.size.z; ++z) {
    absolute[static_cast<size_t>(z)] = series.position(z).z;
  }
  volume = open_data(dose(series, absolute, 0.01));
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series, 0.01);

  absolute[0] += 1;
  expect_open_error(dose(series, absolute, 1), {"frame offsets"});
  absolute.pop_back();
  expect_open_error(dose(series, absolute, 1), {"12 frames and 11 offsets"});
  relative[5] += 0.9;
  expect_open_error(dose(series, relative, 1), {"unevenly spaced"});
}

TEST_F(DicomFrames, ANegativeSpacingGoesAgainstTheNormal) {
  BallSeries series;
  series.modality = "NM";
  for (const double spacing : {2.0, -2.0}) {
    DicomItem data = series.common();
    std::vector<int> order = frames_of(series);
    if (spacing < 0) std::reverse(order.begin(), order.end());
    data[0x00080008] = dicom_text("CS", "ORIGINAL\\PRIMARY\\RECON TOMO\\EMISSION");
    data[0x00180088] = dicom_text("DS", fmt::format("{}", spacing));
    data[0x00180050] = dicom_text("DS", "5");
    data[0x00280008] = dicom_text("IS", std::to_string(series.size.z));
    data[0x00280030] = series.pixel_spacing_value();
    data[0x00540022] = dicom_sequence({{{0x00200032, series.position_value(order[0])},
                                        {0x00200037, series.orientation_value()}}});
    data[0x7fe00010] = dicom_numbers("OW", all_pixels(series, order));
    expect_series(data, series);
    // Frames in another order, with their slice numbers.
    std::vector<uint16_t> numbers;
    std::vector<int> mixed;
    for (const int i : {5, 0, 11, 3, 7, 1, 9, 2, 10, 4, 8, 6}) {
      numbers.push_back(static_cast<uint16_t>(i + 1));
      mixed.push_back(order[static_cast<size_t>(i)]);
    }
    data[0x00540080] = dicom_numbers("US", numbers);
    data[0x7fe00010] = dicom_numbers("OW", all_pixels(series, mixed));
    expect_series(data, series);
  }
}

TEST_F(DicomFrames, FilmsAndProjectionsAreRefused) {
  const BallSeries series;
  DicomItem data = series.common();
  data[0x00280008] = dicom_text("IS", std::to_string(series.size.z));
  data[0x7fe00010] = dicom_numbers("OW", all_pixels(series, frames_of(series)));
  DicomItem film = data;
  film[0x00080060] = dicom_text("CS", "XA");
  film[0x00181063] = dicom_text("DS", "33");
  expect_open_error(film, {"frames of a film"});
  DicomItem projections = data;
  projections[0x00080060] = dicom_text("CS", "NM");
  projections[0x00080008] = dicom_text("CS", "ORIGINAL\\PRIMARY\\TOMO\\EMISSION");
  expect_open_error(projections, {"projections"});
}

TEST_F(DicomFrames, FramesWithoutPositionsAreStackedWithANote) {
  const BallSeries series;
  DicomItem data = series.common();
  data[0x00280008] = dicom_text("IS", std::to_string(series.size.z));
  data[0x00280030] = series.pixel_spacing_value();
  data[0x00180050] = dicom_text("DS", "2");
  data[0x7fe00010] = dicom_numbers("OW", all_pixels(series, frames_of(series)));
  expect_note(data, "2 mm is assumed, the slice thickness");
}

TEST_F(DicomFrames, ContradictionsAreErrors) {
  const BallSeries series;
  const DicomItem data = series.enhanced(frames_of(series));
  DicomItem changed = data;
  changed[0x52009230].items.pop_back();
  expect_open_error(changed, {"12 frames and 11 items"});
  changed = data;
  changed[0x52009230].items[3].erase(0x00209113);
  expect_open_error(changed, {"others have none"});
  changed = data;
  changed[0x00280008] = dicom_text("IS", "13");
  expect_open_error(changed, {"13 frames and 12 items"});
  changed = data;
  changed[0x52009230].items[3][0x00209113] =
      dicom_sequence({{{0x00200032, dicom_text("DS", "1\\x\\3")}}});
  expect_open_error(changed, {"position"});
  changed = data;
  changed[0x52009230].items[3][0x00209113] =
      dicom_sequence({{{0x00200032, series.position_value(4)}}});
  expect_open_error(changed, {"at the same position", "frame 4 of", "frame 5 of"});
}

TEST_F(DicomFrames, TruncatedFilesAreErrorsOrHaveAbsentVoxels) {
  const BallSeries series;
  const TempFolder folder;
  const std::string whole = DicomWriter({}).file(series.enhanced(frames_of(series)));
  const auto path = folder / "a.dcm";
  write_file(path, whole.substr(0, whole.size() - 1000));
  const auto refused = open_volume(path, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::truncated);
  ImportOptions options;
  options.allowed.add(Allowance::truncated);
  auto volume = open_volume(path, options);
  ASSERT_TRUE(volume) << volume.error().message;
  const auto values = test::read_all(*volume->source);
  const auto pixels = all_pixels(series, frames_of(series));
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (i < pixels.size() - 500) {
      EXPECT_EQ(values[i], pixels[i]);
    } else {
      EXPECT_TRUE(std::isnan(values[i]));
    }
  }
}

}  // namespace
}  // namespace isosplat::import
