#include "tests/native/dicom_files.h"

// Real World Value Mapping: the values of pixels if the file has no Rescale Slope.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_numbers;
using test::dicom_sequence;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;

struct Mapping {
  double slope = 0.5, intercept = -20;
  uint16_t first = 0, last = 65535;
  std::string label = "ADC";

  DicomItem item() const {
    return {{0x00283003, dicom_text("LO", "explained")},
            {0x004008ea, dicom_sequence({{{0x00080100, dicom_text("SH", "um2/s")}}})},
            {0x00409210, dicom_text("SH", label)},
            {0x00409211, test::dicom_u16(last)},
            {0x00409216, test::dicom_u16(first)},
            {0x00409224, dicom_numbers("FD", std::vector{intercept})},
            {0x00409225, dicom_numbers("FD", std::vector{slope})}};
  }
};

class DicomMapping : public ::testing::Test {
 protected:
  DicomMapping() {
    series_.stored = 16;
    series_.slope = 0.5;
    series_.intercept = series_.add = -20;
    data_ = series_.enhanced({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    shared().erase(0x00289145);  // no Rescale Slope
  }

  DicomItem& shared() { return data_[0x52009229].items[0]; }
  std::vector<DicomItem>& frames() { return data_[0x52009230].items; }

  Result<OpenVolume> open_data() {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    test::write_file(path, DicomWriter({}).file(data_));
    return open_volume(path, {});
  }

  void expect_values(const std::vector<std::string>& notes) {
    auto volume = open_data();
    ASSERT_TRUE(volume) << volume.error().message;
    test::expect_field(*volume, series_, 0.5);
    EXPECT_EQ(volume->notes.size(), notes.size()) << ::testing::PrintToString(volume->notes);
    for (const std::string& note : notes) test::expect_note(*volume, note);
  }

  void expect_refusal(const std::string& text) {
    const auto volume = open_data();
    ASSERT_FALSE(volume);
    EXPECT_NE(volume.error().message.find(text), std::string::npos) << volume.error().message;
  }

  BallSeries series_;
  DicomItem data_;

 private:
  const test::TempFolder folder_;
  int files_ = 0;
};

TEST_F(DicomMapping, IsAppliedWhereverTheFileHasIt) {
  const auto mapping = dicom_sequence({Mapping{}.item()});
  shared()[0x00409096] = mapping;
  expect_values({});
  shared().erase(0x00409096);
  for (DicomItem& frame : frames()) frame[0x00409096] = mapping;
  expect_values({});
  for (DicomItem& frame : frames()) frame.erase(0x00409096);
  data_[0x00409096] = mapping;
  expect_values({});
}

TEST_F(DicomMapping, StaysIntegersWithSlopeAndIntercept) {
  shared()[0x00409096] = dicom_sequence({Mapping{}.item()});
  const auto volume = open_data();
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->source->header().type, VoxelType::u16);
  EXPECT_EQ(volume->source->header().slope, 0.5);
}

TEST_F(DicomMapping, MayDifferFromFrameToFrame) {
  std::vector<uint16_t> pixels;
  for (int z = 0; z < series_.size.z; ++z) {
    series_.slope = 0.25 * (1 + z % 2);
    Mapping mapping;
    mapping.slope = series_.slope;
    frames()[static_cast<size_t>(z)][0x00409096] = dicom_sequence({mapping.item()});
    const auto some = series_.pixels(z);
    pixels.insert(pixels.end(), some.begin(), some.end());
  }
  data_[0x7fe00010] = dicom_numbers("OW", pixels);
  expect_values({"different slopes or intercepts"});
}

TEST_F(DicomMapping, IsNotedIfItCoversFewerValuesThanPixelsCanHave) {
  Mapping mapping;
  mapping.last = 4095;
  shared()[0x00409096] = dicom_sequence({mapping.item()});
  expect_values({"stated for 0 to 4095"});
}

TEST_F(DicomMapping, TheFirstOfSeveralIsUsedWithANote) {
  Mapping other;
  other.slope = 7;
  other.label = "T2";
  shared()[0x00409096] = dicom_sequence({Mapping{}.item(), other.item()});
  expect_values({"also maps its pixels to \"T2\" (um2/s)"});
  // If a mapping occurs twice, there is no choice to make.
  shared()[0x00409096] = dicom_sequence({Mapping{}.item(), Mapping{}.item()});
  expect_values({});
}

TEST_F(DicomMapping, ByPiecesOrTablesIsRefused) {
  Mapping low, high;
  low.last = 1000;
  high.first = 1001;
  high.slope = 3;
  shared()[0x00409096] = dicom_sequence({low.item(), high.item()});
  expect_refusal("for ranges of stored values");
  DicomItem table = Mapping{}.item();
  table.erase(0x00409225);
  table.erase(0x00409224);
  shared()[0x00409096] = dicom_sequence({table});
  expect_refusal("no slope and no table");
  table[0x00409212] = dicom_numbers("FD", std::vector<double>(4096, 1.5));
  shared()[0x00409096] = dicom_sequence({table});
  expect_refusal("a table for their values");
}

TEST_F(DicomMapping, RescaleSlopeComesFirst) {
  Mapping other;
  other.slope = 7;
  other.label = "SUVbw";
  shared()[0x00289145] = dicom_sequence(
      {{{0x00281052, dicom_text("DS", "-20")}, {0x00281053, dicom_text("DS", "0.5")}}});
  shared()[0x00409096] = dicom_sequence({other.item()});
  expect_values({"SUVbw"});
  shared()[0x00409096] = dicom_sequence({Mapping{}.item()});  // the same values
  expect_values({});
}

TEST_F(DicomMapping, FloatsAreMappedAndHaveTheirOwnPadding) {
  std::vector<float> pixels;
  for (int z = 0; z < series_.size.z; ++z) {
    for (const uint16_t pixel : series_.pixels(z)) pixels.push_back(pixel);
  }
  pixels[0] = -1e6F;
  data_.erase(0x7fe00010);
  data_[0x00280100] = test::dicom_u16(32);
  data_[0x00280122] = dicom_numbers("FL", std::vector{-1e6F});
  data_[0x7fe00008] = dicom_numbers("OF", pixels);
  shared()[0x00409096] = dicom_sequence({Mapping{}.item()});
  auto volume = open_data();
  ASSERT_TRUE(volume) << volume.error().message;
  test::expect_note(*volume, "according to the file's header");
  const auto values = test::read_all(*volume->source);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(values[1], -20 + 0.5 * pixels[1]);
}

}  // namespace
}  // namespace isosplat::import
