#include <algorithm>

#include "tests/native/dicom_files.h"

// DICOM files with missing pixels, and pixels that stand for no value.
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

/// The bytes of a slice's file up to an element.
std::string cut_before(DicomItem data, uint32_t tag) {
  data.erase(data.lower_bound(tag), data.end());
  return DicomWriter({}).file(data);
}

TEST(DicomMissing, SlicesThatEndBeforeTheirPixelsAreErrors) {
  const BallSeries series;
  // Cut the last slice: if it were ignored without a note, the volume would be shorter.
  const int last = series.size.z - 1;
  const std::string whole = DicomWriter({}).file(series.slice(last));
  for (const std::string& cut :
       {cut_before(series.slice(last), 0x7fe00010), cut_before(series.slice(last), 0x00280010),
        cut_before(series.slice(last), 0x00080016), whole.substr(0, 131), whole.substr(0, 60),
        std::string()}) {
    SCOPED_TRACE(cut.size());
    const TempFolder folder;
    series.write(folder);
    std::filesystem::remove(folder / series.file_name(last));
    write_file(folder / "IM12", cut);  // a name without meaning
    expect_open_error(folder.path(), {"IM12", "ends before its pixels", "--allow-gaps"});
    auto volume = open(folder.path(), allowing(Allowance::gaps));
    expect_note(volume, "1 file is ignored, which cannot be read (IM12)");
    EXPECT_EQ(volume.source->header().grid.voxels.z, last);
  }
}

TEST(DicomMissing, ACutDeflatedSliceIsFoundWhenTheFolderIsOpened) {
  BallSeries series;
  series.syntax = test::deflated_little();
  const TempFolder folder;
  series.write(folder);
  // Pixels that compress badly, so that most of the file is pixels.
  auto pixels = series.pixels(6);
  uint32_t random = 1;
  for (uint16_t& pixel : pixels)
    pixel = static_cast<uint16_t>((random = random * 1664525 + 1) >> 20);
  DicomItem data = series.slice(6);
  data[0x7fe00010] = test::dicom_numbers("OW", pixels);
  series.write_slice(folder, 6, data);
  const std::string name = series.file_name(6);
  const std::string whole = test::read_file(folder / name);
  write_file(folder / name, whole.substr(0, whole.size() - whole.size() / 4));
  expect_open_error(folder.path(), {name, "end before their last pixel", "--allow-truncated"});

  auto volume = open(folder.path(), allowing(Allowance::truncated));
  ASSERT_TRUE(volume.source);
  expect_note(volume, "the missing pixels have no value");
  const auto values = test::read_all(*volume.source);
  const size_t slice = pixels.size();
  const auto there =
      static_cast<size_t>(std::find_if(values.begin() + static_cast<std::ptrdiff_t>(6 * slice),
                                       values.end(), [](double v) { return std::isnan(v); }) -
                          values.begin());
  EXPECT_GT(there, 6 * slice);
  EXPECT_LT(there, 7 * slice);
  for (size_t i = 0; i < slice; ++i) {
    const double value = values[6 * slice + i];
    EXPECT_TRUE(6 * slice + i < there ? value == pixels[i] : std::isnan(value)) << i;
  }
}

/// A series in which the first row of each slice has the stored value `padding`.
void write_padded(const TempFolder& folder, const BallSeries& series, int padding,
                  std::optional<int> limit = std::nullopt) {
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    auto pixels = series.pixels(z);
    for (size_t x = 0; x < static_cast<size_t>(series.size.x); ++x) {
      pixels[x] = static_cast<uint16_t>(limit && x % 2 ? *limit : padding);
    }
    data[0x7fe00010] = test::dicom_numbers("OW", pixels);
    const std::string vr = series.is_signed ? "SS" : "US";
    data[0x00280120] = test::dicom_numbers(vr, std::vector{static_cast<uint16_t>(padding)});
    if (limit) {
      data[0x00280121] = test::dicom_numbers(vr, std::vector{static_cast<uint16_t>(*limit)});
    }
    series.write_slice(folder, z, data);
  }
}

TEST(DicomMissing, PaddingApartFromAllValuesHasNoValue) {
  for (const bool has_limit : {false, true}) {
    BallSeries series;
    series.is_signed = true;
    series.stored = 16;
    series.intercept = -1024;
    series.add = -1000;
    const TempFolder folder;
    write_padded(folder, series, -2000, has_limit ? std::optional(-1990) : std::nullopt);
    auto volume = open(folder.path());
    expect_note(volume, has_limit ? "values -3024 to -3014" : "value -3024");
    expect_note(volume, "according to the file's header");
    const auto values = test::read_all(*volume.source);
    const auto nx = static_cast<size_t>(series.size.x);
    const size_t slice = nx * static_cast<size_t>(series.size.y);
    for (size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(std::isnan(values[i]), i % slice < nx) << i;
    }
    EXPECT_EQ(values[3 * slice + nx],
              std::round(series.value(series.position(3) + series.column * series.spacing.y)));
    ImportOptions options;
    options.finds_missing_values = false;
    auto kept = open(folder.path(), options);
    EXPECT_EQ(test::read_all(*kept.source)[0], -3024);
    EXPECT_EQ(kept.source->header().type, VoxelType::i32);
  }
}

// If air is written as padding, making it absent would leave holes in the skin.
TEST(DicomMissing, PaddingAmongOtherValuesIsKeptAndNoted) {
  BallSeries series;
  const TempFolder folder;
  write_padded(folder, series, 0);
  auto volume = open(folder.path());
  expect_note(volume, "--missing-value=0 removes them");
  EXPECT_EQ(volume.source->header().type, VoxelType::u16);
  EXPECT_EQ(test::read_all(*volume.source)[0], 0);
}

TEST(DicomMissing, PaddingThatDiffersFromSliceToSliceIsKeptAndNoted) {
  const BallSeries series;
  const TempFolder folder;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x00280120] = test::dicom_u16(static_cast<uint16_t>(3500 + z));
    series.write_slice(folder, z, data);
  }
  auto volume = open(folder.path());
  expect_field(volume, series);
  expect_note(volume, "different padding values");
}

}  // namespace
}  // namespace isosplat::import
