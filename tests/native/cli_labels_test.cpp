// isosplat build --labels: a scene with a layer for each label.

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>

#include "shared/core/scene/scene.h"
#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_file;

constexpr int kEdge = 40;

/// A cube of kEdge³ labels.
template <class T>
struct Labels {
  std::vector<T> voxels = std::vector<T>(kEdge * kEdge * kEdge);

  void add_ball(T label, double x, double y, double z, double radius) {
    size_t i = 0;
    for (int k = 0; k < kEdge; ++k) {
      for (int j = 0; j < kEdge; ++j) {
        for (int l = 0; l < kEdge; ++l, ++i) {
          if (std::hypot(l - x, j - y, k - z) <= radius) voxels[i] = label;
        }
      }
    }
  }
  uint64_t count(T label) const {
    return static_cast<uint64_t>(std::count(voxels.begin(), voxels.end(), label));
  }
};

/// A ball within a ball, a ball that touches them, and one at the border of the volume.
template <class T>
Labels<T> four_labels(std::array<T, 4> values) {
  Labels<T> labels;
  labels.add_ball(values[0], 20, 20, 20, 12);
  labels.add_ball(values[1], 20, 20, 21, 8);
  labels.add_ball(values[2], 10, 20, 20, 7);
  labels.add_ball(values[3], 0, 0, 0, 15);
  return labels;
}

/// The volume within the triangles of a binary STL file, in its units.
double stl_volume(const std::string& path) {
  const std::string file = read_file(path);
  uint32_t count = 0;
  EXPECT_GE(file.size(), 84u);
  std::memcpy(&count, file.data() + 80, 4);
  EXPECT_EQ(file.size(), 84 + size_t{50} * count);
  double six = 0;
  for (size_t i = 0; i < count; ++i) {
    float v[12];
    std::memcpy(v, file.data() + 84 + 50 * i, sizeof v);
    const Vec3d a{v[3], v[4], v[5]}, b{v[6], v[7], v[8]}, c{v[9], v[10], v[11]};
    six += dot(a, cross(b, c));
  }
  return std::abs(six) / 6;
}

class CliLabels : public ::testing::Test {
 protected:
  template <class T>
  std::string write(const std::string& name, const char* type, const Labels<T>& labels) {
    const std::string path = folder / name;
    std::string voxels(labels.voxels.size() * sizeof(T), '\0');
    std::memcpy(voxels.data(), labels.voxels.data(), voxels.size());
    write_file(path, fmt::format("NRRD0004\ntype: {0}\ndimension: 3\nspace: "
                                 "left-posterior-superior\nsizes: {1} {1} {1}\nspace directions: "
                                 "(0.5,0,0) (0,1,0) (0,0,2)\nspace origin: (10,20,30)\n"
                                 "encoding: raw\nendian: little\n\n",
                                 type, kEdge) +
                         voxels);
    return path;
  }

  Scene scene_of(const std::filesystem::path& path) {
    const auto file = SceneFile::open(path);
    EXPECT_TRUE(file) << (file ? "" : file.error().message);
    return file ? file->scene() : Scene{};
  }

  const TempFolder folder;
  const std::string output = folder / "out.isobundle";
};

TEST_F(CliLabels, EachLabelIsALayerWithItsVoxelsAndPosition) {
  const auto labels = four_labels<uint8_t>({1, 5, 7, 200});
  const std::string volume = write("seg.nrrd", "uint8", labels);
  const Ended built = run({"build", volume, "--labels", "-o", output});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("4 labels"), std::string::npos) << built.out;
  EXPECT_EQ(run({"verify", output}).exit_code, 0);
  const Scene scene = scene_of(output);
  ASSERT_EQ(scene.layers.size(), 4u);
  std::set<std::array<float, 3>> colours;
  for (size_t i = 0; i < 4; ++i) {
    const SceneLayer& layer = scene.layers[i];
    const auto value = std::array<uint8_t, 4>{1, 5, 7, 200}[i];
    EXPECT_EQ(layer.name, fmt::format("label {}", value));
    ASSERT_TRUE(layer.label);
    EXPECT_EQ(layer.label->value, value);
    EXPECT_EQ(layer.label->voxels, labels.count(value));
    EXPECT_DOUBLE_EQ(layer.label->volume, static_cast<double>(labels.count(value)));
    ASSERT_EQ(layer.surfaces.size(), 1u);
    colours.insert(*layer.surfaces[0].colour);
  }
  EXPECT_EQ(colours.size(), 4u);
  // The box of label 5: a ball of radius 8 around (20, 20, 21), from which label 7 has cut two
  // voxels, and two voxels around it, up to a multiple of four cells.
  const auto file = SceneFile::open(output);
  const auto store = file->open_store(scene.layers[1].stores[0]);
  ASSERT_TRUE(store);
  const VolumeGrid& grid = (*store)->info().grid;
  EXPECT_EQ(grid.voxels.x, 21);
  EXPECT_EQ(grid.voxels.y, 21);
  EXPECT_DOUBLE_EQ(grid.origin.x, 10 + 0.5 * 12);
  EXPECT_DOUBLE_EQ(grid.origin.y, 20 + 1.0 * 10);
  EXPECT_DOUBLE_EQ(grid.origin.z, 30 + 2.0 * 11);
}

TEST_F(CliLabels, SurfacesEncloseTheVolumesOfTheirVoxels) {
  const auto labels = four_labels<uint8_t>({1, 5, 7, 200});
  const std::string volume = write("seg.nrrd", "uint8", labels);
  for (const bool raw : {false, true}) {
    std::vector<std::string> call{"build", volume, "-o", folder / "out/", "--force", "--labels"};
    if (raw) call.push_back("raw");
    ASSERT_EQ(run(call).exit_code, 0);
    const Scene scene = scene_of(folder / "out/scene.json");
    ASSERT_EQ(scene.layers.size(), 4u);
    for (const SceneLayer& layer : scene.layers) {
      const std::string mesh = folder / "mesh.stl";
      const Ended extracted =
          run({"extract", folder / ("out/" + layer.stores[0]), "--isovalue",
               fmt::format("{}", layer.surfaces[0].isovalue), "--mesh", "-o", mesh, "--force"});
      ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
      // Stairs lose their edges: the surface cuts them at half a voxel.
      EXPECT_NEAR(stl_volume(mesh) / layer.label->volume, 1, raw ? 0.04 : 0.01) << layer.name;
    }
  }
}

TEST_F(CliLabels, ValuesOfAllTypesAreLabelsIncludingNegativeOnes) {
  const auto check = [&](const std::string& volume, std::vector<int64_t> expected) {
    const Ended built = run({"build", "--labels", volume, "-o", output});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    std::vector<int64_t> values;
    for (const SceneLayer& layer : scene_of(output).layers) values.push_back(layer.label->value);
    EXPECT_EQ(values, expected);
  };
  check(write("i16.nrrd", "int16", four_labels<int16_t>({-3, 4, 300, -32768})),
        {-32768, -3, 4, 300});
  check(write("u32.nrrd", "uint32", four_labels<uint32_t>({7, 4294967295, 65536, 12})),
        {7, 12, 65536, 4294967295});
  check(write("f32.nrrd", "float", four_labels<float>({1, 2, -9, 1e6F})), {-9, 1, 2, 1000000});
}

TEST_F(CliLabels, NamesAndColoursAreThoseOfATableOrOfTheFile) {
  const std::string volume = write("seg.nrrd", "uint8", four_labels<uint8_t>({1, 5, 7, 200}));
  const std::string table = folder / "organs.csv";
  write_file(table, "value,name,r,g,b,a\n5,liver,255,0,0,128\n0,rest,0,255,0,255\n");
  ASSERT_EQ(run({"build", volume, "--labels", "-o", output, "--label-table", table}).exit_code, 0);
  Scene scene = scene_of(output);
  ASSERT_EQ(scene.layers.size(), 5u);  // 0 is a label, since the table names it
  EXPECT_EQ(scene.layers[0].name, "rest");
  EXPECT_EQ(scene.layers[1].name, "label 1");
  EXPECT_EQ(scene.layers[2].name, "liver");
  EXPECT_EQ(*scene.layers[2].surfaces[0].colour, (std::array<float, 3>{1, 0, 0}));
  EXPECT_NEAR(scene.layers[2].surfaces[0].opacity, 0.5, 0.01);
  std::string text = read_file(volume);
  const std::string fields = "Segment0_Name:=spleen\nSegment0_LabelValue:=7\n";
  write_file(folder / "seg.seg.nrrd", text.insert(text.find("\n\n") + 1, fields));
  ASSERT_EQ(run({"build", folder / "seg.seg.nrrd", "--labels", "-o", output}).exit_code, 0);
  scene = scene_of(output);
  ASSERT_EQ(scene.layers.size(), 4u);
  EXPECT_EQ(scene.layers[2].name, "spleen");
  write_file(table, "value,name\nx,liver\n");
  const Ended refused = run({"build", volume, "--labels", "-o", output, "--label-table", table});
  EXPECT_NE(refused.err.find("organs.csv: line 2: expected an integer"), std::string::npos)
      << refused.err;
}

TEST_F(CliLabels, AnInterruptedBuildGoesOnAndTheBytesDoNotDependOnThreads) {
  const std::string volume = write("seg.nrrd", "uint8", four_labels<uint8_t>({1, 5, 7, 200}));
  const std::string other = folder / "other.isobundle";
  ASSERT_EQ(run({"build", volume, "--labels", "-o", other, "--threads", "1"}).exit_code, 0);
  const std::string whole = read_file(other);
  // The program ends while it writes the bundle, because the bundle exceeds the limit on file
  // sizes.
  const Ended cut = run(test::Call{
      .arguments = {"build", volume, "--labels", "-o", output, "--threads", "3", "--name", "other"},
      .file_limit = whole.size() / 2});
  EXPECT_NE(cut.exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(output));
  const Ended built =
      run({"build", volume, "--labels", "-o", output, "--threads", "3", "--name", "other"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("stores were complete before"), std::string::npos) << built.out;
  EXPECT_EQ(read_file(output), whole);
}

TEST_F(CliLabels, RefusesVolumesWithoutLabelsOrWithTooMany) {
  const auto refuses = [&](const std::string& volume, const char* expected) {
    const Ended built = run({"build", volume, "--labels", "-o", output});
    EXPECT_NE(built.exit_code, 0);
    EXPECT_NE(built.err.find(expected), std::string::npos) << built.err;
    EXPECT_FALSE(std::filesystem::exists(output));
  };
  Labels<uint16_t> many;
  for (size_t i = 0; i < many.voxels.size(); ++i) many.voxels[i] = static_cast<uint16_t>(i);
  refuses(write("many.nrrd", "uint16", many), "at most 4096 labels");
  refuses(write("none.nrrd", "uint16", Labels<uint16_t>{}), "only the background");
  refuses(write("half.nrrd", "float", four_labels<float>({1, 2, 2.5F, 3})), "found 2.5");
  refuses(write("large.nrrd", "double", four_labels<double>({1, 2, 1e17, 3})), "2^53");
  const std::string volume = write("seg.nrrd", "uint8", four_labels<uint8_t>({1, 5, 7, 200}));
  EXPECT_NE(run({"build", volume, volume, "--labels", "-o", output}).exit_code, 0);
  const Ended store = run({"build", volume, "--labels", "-o", folder / "out.isosplat"});
  EXPECT_NE(store.err.find("expected a bundle"), std::string::npos) << store.err;
  // The default is a bundle beside the volume.
  ASSERT_EQ(run({"build", volume, "--labels"}).exit_code, 0);
  EXPECT_EQ(scene_of(folder / "seg.isobundle").layers.size(), 4u);
}

TEST_F(CliLabels, ANoteSuggestsLabelsForSegmentationsOnly) {
  const auto note_of = [&](const std::string& volume) {
    const Ended built =
        run({"build", volume, "-o", folder / "x.isosplat", "--no-thumbnail", "--force"});
    EXPECT_EQ(built.exit_code, 0) << built.err;
    return built.err.find("looks like a segmentation") != std::string::npos;
  };
  EXPECT_TRUE(note_of(write("a.nrrd", "uint8", four_labels<uint8_t>({1, 5, 7, 200}))));
  EXPECT_TRUE(note_of(write("b.nrrd", "int32", four_labels<int32_t>({1, 1, 1, 1}))));
  EXPECT_FALSE(note_of(write("c.nrrd", "float", four_labels<float>({1, 5, 7, 200}))));
  EXPECT_FALSE(note_of(test::write_ball(folder, 40)));
  Labels<uint8_t> noise;
  for (size_t i = 0; i < noise.voxels.size(); ++i)
    noise.voxels[i] = static_cast<uint8_t>(i * 2654435761u >> 30);
  EXPECT_FALSE(note_of(write("d.nrrd", "uint8", noise)));
}

TEST_F(CliLabels, NoNoteForMeasuredVolumes) {
  ISOSPLAT_NEEDS_VOLUMES(volumes);
  for (const char* name : {"engine.nhdr", "aneurysm.nhdr", "fuel.nhdr", "bonsai.nhdr",
                           "neghip.nhdr", "BostonTeapot.nhdr", "cthead_tif", "eun_brain.nii.gz"}) {
    const Ended built =
        run({"build", volumes / name, "-o", folder / "x.isosplat", "--no-thumbnail", "--force"});
    EXPECT_EQ(built.exit_code, 0) << built.err;
    EXPECT_EQ(built.err.find("looks like a segmentation"), std::string::npos) << name;
  }
}

TEST_F(CliLabels, ThinLabelsAndAFullVolumeHaveSurfaces) {
  Labels<uint8_t> labels;
  for (size_t i = 0; i < labels.voxels.size(); ++i) labels.voxels[i] = 9;
  for (int k = 0; k < kEdge; ++k) {
    for (int j = 0; j < kEdge; ++j) {
      labels.voxels[static_cast<size_t>((k * kEdge + j) * kEdge + 17)] = 3;
    }
  }
  labels.voxels[0] = 4;
  const std::string volume = write("thin.nrrd", "uint8", labels);
  ASSERT_EQ(run({"build", volume, "--labels", "-o", folder / "out/"}).exit_code, 0);
  const Scene scene = scene_of(folder / "out/scene.json");
  ASSERT_EQ(scene.layers.size(), 3u);
  for (const SceneLayer& layer : scene.layers) {
    const std::string mesh = folder / "mesh.stl";
    ASSERT_EQ(run({"extract", folder / ("out/" + layer.stores[0]), "--isovalue",
                   fmt::format("{}", layer.surfaces[0].isovalue), "--mesh", "-o", mesh, "--force"})
                  .exit_code,
              0);
    EXPECT_GT(stl_volume(mesh), 0.05 * layer.label->volume) << layer.name;
    EXPECT_LT(stl_volume(mesh), 1.05 * layer.label->volume) << layer.name;
  }
}

}  // namespace
}  // namespace isosplat
