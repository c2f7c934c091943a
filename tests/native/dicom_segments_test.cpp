#include <algorithm>

#include "tests/native/dicom_segmentation.h"

// Segmentations: 1-bit, fractional and label maps.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_sequence;
using test::dicom_text;
using test::dicom_u16;
using test::DicomItem;
using test::DicomWriter;
using test::expect_note;

using Type = test::SegmentType;

/// A segmentation of the three balls. Segment 1 (label "low") contains values of at least 300,
/// segment 2 ("high") values of at least 1200, so they overlap.
struct SegmentFile {
  BallSeries series;
  Type type = Type::binary;
  bool omits_empty = true;
  bool states_distance = true;
  std::vector<int> slices;  ///< the slices that may have frames

  SegmentFile() {
    series.size = {19, 17, 12};  // rows and frames do not fill whole bytes
    for (int z = 0; z < series.size.z; ++z) slices.push_back(z);
  }

  static double threshold(int segment) { return segment == 1 ? 300 : 1200; }

  uint8_t value(Vec3d world, int segment) const {
    const double v = series.value(world);
    if (type == Type::labels) return v >= threshold(2) ? 2 : v >= threshold(1) ? 1 : 0;
    if (v < threshold(segment)) return 0;
    return type == Type::binary ? 1 : static_cast<uint8_t>(std::min(200.0, v / 20));
  }

  std::vector<uint8_t> frame(int z, int segment) const {
    std::vector<uint8_t> pixels;
    for (int y = 0; y < series.size.y; ++y) {
      for (int x = 0; x < series.size.x; ++x) {
        pixels.push_back(value(series.position(z) + series.row * (series.spacing.x * x) +
                                   series.column * (series.spacing.y * y),
                               segment));
      }
    }
    return pixels;
  }

  DicomItem data() const {
    DicomItem measures{{0x00280030, series.pixel_spacing_value()}};
    if (states_distance) measures[0x00180088] = dicom_text("DS", "2");
    test::Segmentation made(
        series, type, {test::segment_description(1, "low"), test::segment_description(2, "high")},
        std::move(measures));
    for (int segment = 1; segment <= (type == Type::labels ? 1 : 2); ++segment) {
      for (const int z : slices) {
        const auto pixels = frame(z, segment);
        const bool is_empty =
            std::all_of(pixels.begin(), pixels.end(), [](int v) { return v == 0; });
        if (!is_empty || !omits_empty) made.add(series.position_value(z), pixels, segment);
      }
    }
    DicomItem data = made.data();
    if (type == Type::fractional) data[0x00620010] = dicom_text("CS", "PROBABILITY");
    if (type == Type::labels) data[0x00280120] = dicom_u16(0);
    return data;
  }
};

class DicomSegments : public ::testing::Test {
 protected:
  std::filesystem::path write(const DicomItem& data, const test::DicomSyntax& syntax = {}) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    test::write_file(path, DicomWriter(syntax).file(data));
    return path;
  }

  static ImportOptions choosing(const std::string& segment) {
    ImportOptions options;
    options.segment = segment;
    return options;
  }

  /// Expects that every voxel has the value of its position. `number`: of the segment. With
  /// `as_mask`, voxels of the label map are 1 if they have this number.
  static void expect_segment(OpenVolume& volume, const SegmentFile& file, int number,
                             bool as_mask = false) {
    ASSERT_TRUE(volume.source);
    const VolumeGrid& grid = volume.source->header().grid;
    const auto values = test::read_all(*volume.source);
    size_t i = 0, wrong = 0, inside = 0;
    for (int z = 0; z < grid.voxels.z; ++z) {
      for (int y = 0; y < grid.voxels.y; ++y) {
        for (int x = 0; x < grid.voxels.x; ++x, ++i) {
          int expected = file.value(grid.world({double(x), double(y), double(z)}), number);
          if (as_mask) expected = expected == number ? 1 : 0;
          wrong += values[i] != expected;
          inside += expected > 0;
        }
      }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(inside, 20u);
    EXPECT_EQ(volume.source->header().type, VoxelType::u8);
  }

  const test::TempFolder folder_;

 private:
  int files_ = 0;
};

TEST_F(DicomSegments, OneOfSeveralIsChosenByNumberOrLabel) {
  SegmentFile file;
  for (const Type type : {Type::binary, Type::fractional}) {
    file.type = type;
    for (const bool omits : {false, true}) {
      file.omits_empty = omits;
      const auto path = write(file.data());
      test::expect_open_error(
          path, {"found 2 in a segmentation", "--segment 1 or \"low\"", "--segment 2 or \"high\""});
      for (const auto& [choice, number] : {std::pair{"1", 1}, {"low", 1}, {"2", 2}, {"High", 2}}) {
        auto volume = test::open(path, choosing(choice));
        expect_segment(volume, file, number);
        EXPECT_GT(volume.source->header().grid.voxels.z, 8);
        expect_note(volume, number == 1 ? "segment 1 (\"low\") of 2" : "segment 2 (\"high\") of 2");
        if (type == Type::fractional) expect_note(volume, "200 stands for 1");
      }
      test::expect_open_error(path, {"none that is \"bone\"", "--segment 1"}, choosing("bone"));
      test::expect_open_error(path, {"none that is \"3\""}, choosing("3"));
    }
  }
}

TEST_F(DicomSegments, AreOfferedAsChoices) {
  SegmentFile file;
  const auto path = write(file.data());
  std::vector<VolumeChoice> choices;
  ImportOptions options;
  options.choices = &choices;
  EXPECT_FALSE(open_volume(path, options));
  ASSERT_EQ(choices.size(), 2u);
  options.choices = nullptr;
  for (int number = 1; number <= 2; ++number) {
    const VolumeChoice& choice = choices[static_cast<size_t>(number - 1)];
    EXPECT_EQ(choice.name, number == 1 ? "low" : "high");
    options.segment = choice.segment;
    auto volume = test::open(path, options);
    expect_segment(volume, file, number);
  }
}

TEST_F(DicomSegments, SeriesBesideThemAreOfferedAsWell) {
  SegmentFile file;
  DicomItem data = file.data();
  data[0x0020000e] = dicom_text("UI", "1.2.3.5");
  write(data);
  file.series.write(folder_);
  std::vector<VolumeChoice> choices;
  ImportOptions options;
  options.choices = &choices;
  auto volume = test::open(folder_.path(), options);
  test::expect_field(volume, file.series);
  ASSERT_EQ(choices.size(), 2u);
  EXPECT_TRUE(choices[1].label.starts_with("series 2: SEG, ")) << choices[1].label;
  options.series = choices[1].series;
  EXPECT_FALSE(open_volume(folder_.path(), options));
  ASSERT_EQ(choices.size(), 2u);
  options.segment = choices[1].segment;
  volume = test::open(folder_.path(), options);
  expect_segment(volume, file, 2);
  EXPECT_TRUE(choices.empty());
}

TEST_F(DicomSegments, EverySyntaxHasTheSameBits) {
  const SegmentFile file;
  for (const auto& syntax :
       {test::implicit_little(), test::explicit_big(), test::deflated_little()}) {
    auto volume = test::open(write(file.data(), syntax), choosing("1"));
    expect_segment(volume, file, 1);
  }
  DicomItem words = file.data();
  words[0x7fe00010].vr = "OW";
  words[0x7fe00010].unit = 2;
  auto volume = test::open(write(words, test::explicit_big()), choosing("1"));
  expect_segment(volume, file, 1);
}

TEST_F(DicomSegments, OmittedFramesAreOutsideTheSegment) {
  SegmentFile file;
  file.slices = {0, 1, 2, 5, 6, 9, 10, 11};
  for (const bool states : {true, false}) {
    file.states_distance = states;
    for (const ImportOptions& allowed : {ImportOptions{}, test::allowing(Allowance::gaps)}) {
      ImportOptions options = allowed;
      options.segment = "1";
      auto volume = test::open(write(file.data()), options);
      expect_note(volume, "are outside the segment");
      const VolumeGrid& grid = volume.source->header().grid;
      const auto values = test::read_all(*volume.source);
      const size_t slice = values.size() / static_cast<size_t>(grid.voxels.z);
      size_t wrong = 0, i = 0;
      for (int z = 0; z < grid.voxels.z; ++z) {
        for (size_t k = 0; k < slice; ++k, ++i) {
          const int x = static_cast<int>(k) % grid.voxels.x,
                    y = static_cast<int>(k) / grid.voxels.x;
          const Vec3d world = grid.world({double(x), double(y), double(z)});
          const int place =
              static_cast<int>(std::lround((world.z - file.series.position(0).z) / 2));
          const bool is_there = std::count(file.slices.begin(), file.slices.end(), place) > 0;
          wrong += values[i] != (is_there ? file.value(world, 1) : 0);
        }
      }
      EXPECT_EQ(wrong, 0u);
      if (!states) expect_note(volume, "the smallest distance between its frames, 2 mm");
    }
  }
  // Frames whose distances have no common divisor are not a volume.
  DicomItem data = file.data();
  auto& frames = data[0x52009230].items;
  const Vec3d p = file.series.position(1) + Vec3d{0, 0, 0.7};
  for (DicomItem& frame : frames) {
    DicomItem& plane = frame[0x00209113].items[0];
    if (plane[0x00200032].bytes == file.series.position_value(1).bytes) {
      plane[0x00200032] = dicom_text("DS", test::dicom_decimals({p.x, p.y, p.z}));
    }
  }
  test::expect_open_error(write(data), {"at even steps"}, choosing("1"));
}

TEST_F(DicomSegments, TheOnlySegmentNeedsNoChoice) {
  SegmentFile file;
  DicomItem data = file.data();
  data[0x00620002] = dicom_sequence({test::segment_description(1, "low")});
  auto& frames = data[0x52009230].items;
  std::erase_if(frames, [](DicomItem& frame) {
    return frame[0x0062000a].items[0][0x0062000b].bytes[0] == 2;
  });
  std::vector<uint8_t> pixels;
  for (const int z : file.slices) {
    const auto some = file.frame(z, 1);
    if (std::count(some.begin(), some.end(), 1) > 0) {
      pixels.insert(pixels.end(), some.begin(), some.end());
    }
  }
  data[0x00280008] = dicom_text("IS", std::to_string(frames.size()));
  data[0x7fe00010] = test::dicom_bits(pixels);
  auto volume = test::open(write(data));
  expect_segment(volume, file, 1);
  EXPECT_TRUE(volume.notes.empty()) << ::testing::PrintToString(volume.notes);
  // A segment that is described, but has no frame.
  data[0x00620002].items.push_back(test::segment_description(5, "nothing"));
  test::expect_open_error(write(data), {"--segment 5 or \"nothing\", 0 frames"});
  test::expect_open_error(write(data), {"has no frames: it is empty"}, choosing("nothing"));
}

TEST_F(DicomSegments, ALabelMapKeepsItsBackground) {
  SegmentFile file;
  file.type = Type::labels;
  for (const char* photometric : {"MONOCHROME2", "PALETTE COLOR"}) {
    DicomItem data = file.data();
    data[0x00280004] = dicom_text("CS", photometric);
    const auto path = write(data);
    auto volume = test::open(path);
    expect_segment(volume, file, 1);
    EXPECT_TRUE(volume.notes.empty()) << ::testing::PrintToString(volume.notes);
    auto high = test::open(path, choosing("high"));
    expect_segment(high, file, 2, true);
    expect_note(high, "voxels of segment 2 (\"high\") are 1, all others 0");
    test::expect_open_error(path, {"none that is \"bone\""}, choosing("bone"));
  }
  file.slices = {0, 1, 2, 3, 4, 7, 8, 9, 10, 11};
  auto volume = test::open(write(file.data()));
  expect_note(volume, "2 of");
  const auto values = test::read_all(*volume.source);
  EXPECT_TRUE(std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }));
}

TEST_F(DicomSegments, AnImageBesideItsSegmentationIsRead) {
  SegmentFile file;
  file.omits_empty = false;  // more voxels than the image
  DicomItem data = file.data();
  data[0x0020000e] = dicom_text("UI", "1.2.3.5");
  write(data);
  file.series.write(folder_);
  auto volume = test::open(folder_.path());
  test::expect_field(volume, file.series);
  expect_note(volume, "the others are --series 2: SEG");
  ImportOptions options = choosing("2");
  options.series = "2";
  volume = test::open(folder_.path(), options);
  expect_segment(volume, file, 2);
  test::expect_open_error(folder_.path(), {"--segment", "found an image"}, choosing("2"));
}

TEST_F(DicomSegments, TruncatedBitsAreAnErrorOrAbsent) {
  SegmentFile file;
  const std::string bytes = DicomWriter({}).file(file.data());
  const auto path = folder_ / "cut.dcm";
  test::write_file(path, bytes.substr(0, bytes.size() - 31));
  test::expect_open_error(path, {"--allow-truncated"}, choosing("2"));
  ImportOptions options = test::allowing(Allowance::truncated);
  options.segment = "2";
  auto volume = test::open(path, options);
  ASSERT_TRUE(volume.source);
  const auto values = test::read_all(*volume.source);
  const auto absent =
      std::count_if(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  EXPECT_GE(absent, 30 * 8);
  EXPECT_LE(absent, 32 * 8);
}

}  // namespace
}  // namespace isosplat::import
