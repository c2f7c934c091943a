// All segments of a DICOM segmentation at once, as volumes of labels.

#include <random>
#include <set>

#include "tests/native/segment_boxes.h"

namespace isosplat::import {
namespace {

using test::DicomItem;
using test::five_boxes;
using test::SegmentBox;
using test::SegmentBoxes;
using test::SegmentType;

class DicomSegmentMaps : public ::testing::Test {
 protected:
  std::filesystem::path write(const DicomItem& data, const test::DicomSyntax& syntax = {}) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    test::write_file(path, test::DicomWriter(syntax).file(data));
    return path;
  }

  static std::vector<SegmentMap> open(const std::filesystem::path& path,
                                      const ImportOptions& options = {}) {
    auto maps = open_segments(path, options);
    EXPECT_TRUE(maps) << (maps ? "" : maps.error().message);
    return maps ? std::move(*maps) : std::vector<SegmentMap>{};
  }

  static void expect_error(const std::filesystem::path& path, const std::string& text,
                           const ImportOptions& options = {}) {
    const auto maps = open_segments(path, options);
    ASSERT_FALSE(maps) << "expected an error that contains \"" << text << "\"";
    EXPECT_NE(maps.error().message.find(text), std::string::npos) << maps.error().message;
  }

  /// Expects that each box is in one of the maps, and that each map has its boxes and nothing else.
  static void expect_boxes(std::vector<SegmentMap>& maps, const std::vector<SegmentBox>& boxes) {
    std::set<int> found;
    for (SegmentMap& map : maps) {
      std::vector<SegmentBox> of_map;
      for (const SegmentDescription& segment : map.segments) {
        EXPECT_TRUE(found.insert(segment.number).second);
        for (const SegmentBox& box : boxes) {
          if (box.number != segment.number) continue;
          EXPECT_EQ(segment.label, box.label);
          of_map.push_back(box);
        }
      }
      const VolumeGrid& grid = map.volume.source->header().grid;
      const auto values = test::read_all(*map.volume.source);
      size_t wrong = 0, i = 0;
      for (int z = 0; z < grid.voxels.z; ++z) {
        for (int y = 0; y < grid.voxels.y; ++y) {
          for (int x = 0; x < grid.voxels.x; ++x, ++i) {
            const Vec3d at = grid.world({double(x), double(y), double(z)});
            double expected = 0;
            for (const SegmentBox& box : of_map) {
              if (box.has(int(std::lround(at.x)), int(std::lround(at.y / 1.5)),
                          int(std::lround(at.z / 2)))) {
                expected = box.number;
              }
            }
            wrong += values[i] != expected;
          }
        }
      }
      EXPECT_EQ(wrong, 0u);
    }
    EXPECT_EQ(found.size(), boxes.size());
  }

  const test::TempFolder folder_;

 private:
  int files_ = 0;
};

TEST_F(DicomSegmentMaps, SegmentsThatOverlapAreInDifferentMaps) {
  SegmentBoxes file = five_boxes();
  for (const SegmentType type : {SegmentType::binary, SegmentType::fractional}) {
    file.type = type;
    auto maps = open(write(file.data()));
    ASSERT_EQ(maps.size(), 3u);
    expect_boxes(maps, file.boxes);
    const auto numbers = [&](size_t map) {
      std::vector<int> all;
      for (const auto& segment : maps[map].segments) all.push_back(segment.number);
      return all;
    };
    EXPECT_EQ(numbers(0), (std::vector{1, 2, 9}));
    EXPECT_EQ(numbers(1), (std::vector{3}));
    EXPECT_EQ(numbers(2), (std::vector{4}));
    // Slices 1 to 11 have frames.
    EXPECT_EQ(maps[0].volume.source->header().grid.voxels.z, 11);
    EXPECT_EQ(maps[2].volume.source->header().grid.voxels.z, 11);
    if (type == SegmentType::fractional) {
      test::expect_note(maps[0].volume, "voxels from 100 on belong to them");
    } else {
      EXPECT_TRUE(maps[0].volume.notes.empty()) << ::testing::PrintToString(maps[0].volume.notes);
    }
  }
}

TEST_F(DicomSegmentMaps, EverySyntaxHasTheSameBits) {
  const SegmentBoxes file = five_boxes();
  for (const auto& syntax :
       {test::implicit_little(), test::explicit_big(), test::deflated_little()}) {
    auto maps = open(write(file.data(), syntax));
    expect_boxes(maps, file.boxes);
  }
}

TEST_F(DicomSegmentMaps, FramesOfEachSliceMayBeInAnyOrderAndAbsent) {
  SegmentBoxes file = five_boxes();
  file.boxes.erase(file.boxes.begin(), file.boxes.begin() + 2);  // gaps between the others
  file.boxes[0] = {3, "tumour", {3, 3, 0}, {7, 7, 1}};
  file.boxes[1] = {4, "margin", {5, 2, 5}, {11, 8, 6}};
  std::swap(file.boxes[0], file.boxes[2]);
  auto maps = open(write(file.data()));
  ASSERT_EQ(maps.size(), 1u);
  expect_boxes(maps, file.boxes);
}

TEST_F(DicomSegmentMaps, DescriptionsHaveCodesAndColours) {
  SegmentBoxes file = five_boxes();
  file.boxes[1].meaning = "Spleen";
  file.boxes[2].meaning = "Neoplasm";
  file.boxes[2].modifier = "Left";
  file.boxes[2].cie_lab = {65535, 32896, 0};
  const auto maps = open(write(file.data()));
  ASSERT_EQ(maps.size(), 3u);
  EXPECT_EQ(maps[0].segments[1].meaning, "Spleen");
  EXPECT_FALSE(maps[0].segments[1].cie_lab);
  EXPECT_EQ(maps[1].segments[0].meaning, "Neoplasm, Left");
  ASSERT_TRUE(maps[1].segments[0].cie_lab);
  EXPECT_NEAR((*maps[1].segments[0].cie_lab)[0], 100, 1e-9);
  EXPECT_NEAR((*maps[1].segments[0].cie_lab)[1], 0, 0.01);
  EXPECT_NEAR((*maps[1].segments[0].cie_lab)[2], -128, 1e-9);
}

TEST_F(DicomSegmentMaps, OneSegmentIsChosenByNumberOrLabel) {
  const SegmentBoxes file = five_boxes();
  const auto path = write(file.data());
  for (const char* wanted : {"3", "Tumour"}) {
    ImportOptions options;
    options.segment = wanted;
    auto maps = open(path, options);
    ASSERT_EQ(maps.size(), 1u);
    expect_boxes(maps, {file.boxes[2]});
  }
  ImportOptions options;
  options.segment = "bone";
  expect_error(path, "expected one of the segments 1 (\"liver\"), 2 (\"spleen\")", options);
}

TEST_F(DicomSegmentMaps, ALabelMapIsOneMapWithItsBackground) {
  SegmentBoxes file = five_boxes();
  file.type = SegmentType::labels;
  file.background = 7;
  auto maps = open(write(file.data()));
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].background, 7);
  EXPECT_EQ(maps[0].segments.size(), 5u);
  EXPECT_FALSE(maps[0].only);
  const auto values = test::read_all(*maps[0].volume.source);
  EXPECT_EQ(static_cast<uint64_t>(std::count(values.begin(), values.end(), 4)),
            file.boxes[3].voxels());
  ImportOptions options;
  options.segment = "margin";
  maps = open(write(file.data()), options);
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].only, 4);
  options.segment = "5";
  expect_error(write(file.data()), "for --segment, found \"5\"", options);
}

TEST_F(DicomSegmentMaps, FilesOfASeriesHaveTheirOwnMaps) {
  SegmentBoxes file = five_boxes();
  SegmentBoxes one = file, two = file;
  one.boxes = {file.boxes[0]};
  two.boxes = {{1, "heart", {2, 2, 7}, {9, 9, 10}}};
  write(one.data());
  DicomItem other = two.data();
  other[0x00080018] = test::dicom_text("UI", "1.2.3.4.78");
  write(other);
  test::BallSeries images;  // an image beside them is left out
  images.uid = "1.2.3.5";
  images.write(folder_);
  auto maps = open(folder_.path());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].segments[0].label, "liver");
  EXPECT_EQ(maps[1].segments[0].label, "heart");
  EXPECT_EQ(maps[1].volume.source->header().grid.voxels.z, 4);
  ImportOptions options;
  options.segment = "heart";
  maps = open(folder_.path(), options);
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].segments[0].label, "heart");
}

TEST_F(DicomSegmentMaps, OtherFilesHaveNone) {
  const test::TempFolder images;
  test::BallSeries{}.write(images);
  EXPECT_TRUE(open(images.path()).empty());
  test::write_file(folder_ / "x.nrrd", "NRRD0004\n");
  EXPECT_TRUE(open(folder_ / "x.nrrd").empty());
}

TEST_F(DicomSegmentMaps, ContradictionsAreErrors) {
  const SegmentBoxes file = five_boxes();
  DicomItem data = file.data();
  data[0x52009230].items[3].erase(0x0062000a);
  expect_error(write(data), "does not state its segment");
  data = file.data();
  data[0x7fe00010].bytes.resize(40);
  expect_error(write(data), "--allow-truncated");
  auto maps = open(write(data), test::allowing(Allowance::truncated));
  ASSERT_FALSE(maps.empty());  // what the file lacks is outside
  EXPECT_EQ(test::read_all(*maps[0].volume.source).size(), 19u * 17 * 11);
  // 65 segments with a common pixel.
  SegmentBoxes deep;
  for (int i = 1; i <= 65; ++i) deep.boxes.push_back({i, "x", {2, 2, 2}, {9, 9, 3}});
  expect_error(write(deep.data()), "at most 64 segments with a common pixel");
  deep.boxes.pop_back();
  EXPECT_EQ(open(write(deep.data())).size(), 64u);
}

TEST_F(DicomSegmentMaps, DamagedFilesAreErrorsOrMaps) {
  const std::string bytes = five_boxes().file();
  const auto path = folder_ / "damaged.dcm";
  std::mt19937 random(7);
  for (int i = 0; i < 400; ++i) {
    std::string damaged = bytes;
    for (int edits = 0; edits < 4; ++edits) {
      damaged[132 + random() % (damaged.size() - 132)] = static_cast<char>(random());
    }
    if (i % 5 == 0) damaged.resize(random() % damaged.size());
    test::write_file(path, damaged);
    auto maps = open_segments(path, {});
    if (!maps) continue;
    for (SegmentMap& map : *maps) {
      const Index3 n = map.volume.source->header().grid.voxels;
      if (int64_t{n.x} * n.y * n.z > 1 << 20) continue;
      std::vector<std::byte> out(2 * static_cast<size_t>(n.x) * static_cast<size_t>(n.y) *
                                 static_cast<size_t>(n.z));
      if (map.volume.source->header().type == VoxelType::u16) {
        static_cast<void>(map.volume.source->read_slices(0, n.z, out));
      }
    }
  }
}

}  // namespace
}  // namespace isosplat::import
