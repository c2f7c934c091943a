// isosplat build --labels of segments that may overlap: DICOM segmentations, layers of 3D Slicer.

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "shared/core/scene/scene.h"
#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"
#include "tests/native/segment_boxes.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::SegmentBox;
using test::SegmentBoxes;
using test::SegmentType;
using test::TempFolder;
using test::write_file;

class CliLabelLayers : public ::testing::Test {
 protected:
  Scene build(const std::string& volume, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"build", volume, "--labels", "-o", output});
    const Ended built = run(more);
    EXPECT_EQ(built.exit_code, 0) << built.err;
    last_notes = built.err;
    EXPECT_EQ(run({"verify", output}).exit_code, 0);
    const auto file = SceneFile::open(output);
    EXPECT_TRUE(file) << (file ? "" : file.error().message);
    return file ? file->scene() : Scene{};
  }

  static void expect_boxes(const Scene& scene, const std::vector<SegmentBox>& boxes) {
    ASSERT_EQ(scene.layers.size(), boxes.size());
    std::set<std::string> stores;
    for (size_t i = 0; i < boxes.size(); ++i) {
      const SceneLayer& layer = scene.layers[i];
      EXPECT_EQ(layer.name, boxes[i].label);
      ASSERT_TRUE(layer.label);
      EXPECT_EQ(layer.label->value, boxes[i].number);
      EXPECT_EQ(layer.label->voxels, boxes[i].voxels());
      EXPECT_DOUBLE_EQ(layer.label->volume, 3.0 * static_cast<double>(boxes[i].voxels()));
      stores.insert(layer.stores[0]);
    }
    EXPECT_EQ(stores.size(), boxes.size());
  }

  const TempFolder folder;
  const std::string output = folder / "out.isobundle";
  std::string last_notes;
};

TEST_F(CliLabelLayers, EachSegmentOfADicomSegmentationIsALayer) {
  SegmentBoxes file = test::five_boxes();
  const std::string volume = folder / "seg.dcm";
  for (const SegmentType type : {SegmentType::binary, SegmentType::fractional}) {
    file.type = type;
    write_file(volume, file.file());
    expect_boxes(build(volume), file.boxes);
    expect_boxes(build(volume, {"--segment", "margin"}), {file.boxes[3]});
  }
  const Ended refused = run({"build", volume, "-o", folder / "x.isosplat"});
  EXPECT_NE(refused.err.find("found 5 in a segmentation (isosplat build --labels makes a scene"),
            std::string::npos)
      << refused.err;
}

TEST_F(CliLabelLayers, ALabelMapHasItsSegments) {
  SegmentBoxes file = test::five_boxes();
  file.type = SegmentType::labels;
  file.background = 7;
  file.boxes.erase(file.boxes.begin() + 2, file.boxes.begin() + 4);  // the overlapping boxes
  const std::string volume = folder / "seg.dcm";
  write_file(volume, file.file());
  expect_boxes(build(volume), file.boxes);
  expect_boxes(build(volume, {"--segment", "9"}), {file.boxes[2]});
}

TEST_F(CliLabelLayers, SegmentsHaveTheirColoursAndDistinctNames) {
  SegmentBoxes file = test::five_boxes();
  file.boxes[0].cie_lab = {35579, 53664, 50857};  // red of sRGB
  file.boxes[1].label = file.boxes[2].label = "kidney";
  file.boxes[1].meaning = file.boxes[2].meaning = "Kidney";
  file.boxes[1].modifier = "Left";
  file.boxes[2].modifier = "Right";
  file.boxes[3].label = "";
  file.boxes[3].meaning = "Margin";
  const std::string volume = folder / "seg.dcm", table = folder / "names.csv";
  write_file(volume, file.file());
  Scene scene = build(volume);
  ASSERT_EQ(scene.layers.size(), 5u);
  EXPECT_EQ(scene.layers[1].name, "Kidney, Left");
  EXPECT_EQ(scene.layers[2].name, "Kidney, Right");
  EXPECT_EQ(scene.layers[3].name, "Margin");
  const auto& red = *scene.layers[0].surfaces[0].colour;
  EXPECT_NEAR(red[0], 1, 0.02);
  EXPECT_NEAR(red[1], 0, 0.02);
  EXPECT_NEAR(red[2], 0, 0.02);
  write_file(table, "value,name\n3,other\n");
  scene = build(volume, {"--label-table", table});
  EXPECT_EQ(scene.layers[2].name, "other");
}

TEST_F(CliLabelLayers, SegmentsWithoutPixelsAreNamed) {
  SegmentBoxes file = test::five_boxes();
  file.boxes[3].low.z = 9;
  file.boxes[3].high.z = 8;
  write_file(folder / "seg.dcm", file.file());
  std::vector<SegmentBox> there = file.boxes;
  there.erase(there.begin() + 3);
  expect_boxes(build(folder / "seg.dcm"), there);
  EXPECT_NE(last_notes.find("have no frames, so they are empty: 4 (\"margin\")"), std::string::npos)
      << last_notes;
}

/// A segmentation of 3D Slicer whose layers are boxes of label values, the list axis first.
std::string slicer_file(const std::vector<std::vector<SegmentBox>>& layers,
                        const std::string& fields) {
  constexpr Index3 kSize{19, 17, 12};
  std::string voxels;
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        for (const auto& boxes : layers) {
          char value = 0;
          for (const SegmentBox& box : boxes) {
            if (box.has(x, y, z)) value = static_cast<char>(box.number);
          }
          voxels.push_back(value);
        }
      }
    }
  }
  return fmt::format(
             "NRRD0004\ntype: unsigned char\ndimension: 4\nspace: left-posterior-superior\nsizes: "
             "{} {} {} {}\nspace directions: none (1,0,0) (0,1.5,0) (0,0,2)\nkinds: list domain "
             "domain domain\nencoding: raw\nspace origin: (0,0,0)\n{}\n",
             layers.size(), kSize.x, kSize.y, kSize.z, fields) +
         voxels;
}

TEST_F(CliLabelLayers, LayersOfASlicerSegmentationAreInOneScene) {
  const auto boxes = test::five_boxes().boxes;
  // Values are unique in a layer only.
  SegmentBox liver = boxes[0], spleen = boxes[1], tumour = boxes[2], margin = boxes[3];
  tumour.number = margin.number = 1;
  std::string fields;
  const auto describe = [&](int number, const SegmentBox& box, int layer) {
    fields += fmt::format(
        "Segment{0}_Name:={1}\nSegment{0}_LabelValue:={2}\nSegment{0}_Layer:={3}\n"
        "Segment{0}_Color:=0.{0} 0.5 1\n",
        number, box.label, box.number, layer);
  };
  describe(0, liver, 0);
  describe(1, tumour, 1);
  describe(2, margin, 2);
  describe(3, spleen, 0);
  const std::string volume = folder / "x.seg.nrrd";
  write_file(volume, slicer_file({{liver, spleen}, {tumour}, {margin}, {}}, fields));
  const Scene scene = build(volume);
  expect_boxes(scene, {liver, tumour, margin, spleen});
  EXPECT_NEAR((*scene.layers[2].surfaces[0].colour)[0], 0.2, 0.01);
  const std::string whole = read_file(output);
  expect_boxes(build(volume, {"--force", "--threads", "3"}), {liver, tumour, margin, spleen});
  EXPECT_EQ(read_file(output), whole);
  expect_boxes(build(volume, {"--channel", "2"}), {margin});
  const Ended refused = run({"build", volume, "-o", folder / "x.isosplat"});
  EXPECT_NE(refused.err.find("found 4 channels (layers of a segmentation: isosplat build --labels"),
            std::string::npos)
      << refused.err;
  write_file(volume, slicer_file({{}, {}}, fields));
  EXPECT_NE(run({"build", volume, "--labels", "-o", output}).err.find("only the background"),
            std::string::npos);
}

TEST_F(CliLabelLayers, OldSlicerSegmentationsHaveALayerForEachSegment) {
  SegmentBox liver = test::five_boxes().boxes[0], tumour = test::five_boxes().boxes[2];
  liver.number = tumour.number = 1;
  const std::string volume = folder / "old.seg.nrrd";
  write_file(volume,
             slicer_file({{liver}, {tumour}}, "Segment0_Name:=liver\nSegment1_Name:=tumour\n"));
  expect_boxes(build(volume), {liver, tumour});
}

TEST_F(CliLabelLayers, AnInterruptedBuildGoesOnWithEachLayer) {
  SegmentBoxes file = test::five_boxes();
  const std::string volume = folder / "seg.dcm";
  write_file(volume, file.file());
  expect_boxes(build(volume, {"--name", "x"}), file.boxes);
  const std::string whole = read_file(output);
  std::filesystem::remove(output);
  const Ended cut =
      run(test::Call{.arguments = {"build", volume, "--labels", "-o", output, "--name", "x"},
                     .file_limit = whole.size() / 2});
  EXPECT_NE(cut.exit_code, 0);
  const Ended built = run({"build", volume, "--labels", "-o", output, "--name", "x"});
  EXPECT_NE(built.out.find("stores were complete before"), std::string::npos) << built.out;
  EXPECT_EQ(read_file(output), whole);
}

}  // namespace
}  // namespace isosplat
