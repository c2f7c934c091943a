// Surfaces of meshes, compared with those of VTK's contour filter.

#include <gtest/gtest.h>

#include <sstream>

#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::run;
using test::TempFolder;

test::Ended python(std::vector<std::string> arguments) {
  return test::run(test::Call{.arguments = std::move(arguments), .program = "/usr/bin/python3"});
}

/// What compare_contours.py prints. Distances are in edges of the mesh's cells.
struct Compared {
  double area = 0;                        ///< ratio
  double to_contour = 1, to_surface = 1;  ///< 95th percentiles
  int components = 0, expected_components = 0;
};

/// Builds a mesh, and compares its surface at each isovalue.
class Comparison {
 public:
  Comparison(std::filesystem::path mesh, std::string array)
      : mesh_(std::move(mesh)), array_(std::move(array)) {
    built_ = run({"build", mesh_.string(), "-o", output_, "--dataset", array_, "--no-thumbnail"});
  }

  const test::Ended& built() const { return built_; }

  Compared at(const std::string& isovalue) const {
    const auto scene = SceneFile::open(output_ + "scene.json");
    EXPECT_TRUE(scene);
    if (!scene) return {};
    std::vector<std::string> arguments{ISOSPLAT_SOURCE_DIR "/tests/native/compare_contours.py",
                                       mesh_.string(), array_, isovalue};
    for (const SceneLayer& layer : scene->scene().layers) {
      const std::string surface = output_ + layer.name + isovalue + ".vtp";
      const auto extracted =
          run({"extract", output_ + layer.stores[0], "-i", isovalue, "--mesh", "-o", surface});
      if (extracted.exit_code == 0) arguments.push_back(surface);
    }
    const auto ended = python(arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    std::istringstream numbers(ended.out);
    Compared found;
    numbers >> found.area >> found.to_contour >> found.to_surface >> found.components >>
        found.expected_components;
    // The figures of decision 022.
    std::cout << mesh_.filename().string() << " at " << isovalue << ": " << ended.out;
    return found;
  }

 private:
  std::filesystem::path mesh_;
  std::string array_;
  TempFolder folder_;
  std::string output_ = folder_ / "scene/";
  test::Ended built_;
};

bool has_vtk() {
  return python({"-c", "import vtk"}).exit_code == 0;
}

/// One pair of sheets that nearly touch may be joined.
TEST(CliMeshContours, SurfacesOfTheFireAreThoseOfVtk) {
  const auto volumes = test::volumes_folder();
  if (!volumes) GTEST_SKIP() << "needs volumes";
  const auto file = *volumes / "fire_ug.vtu";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  if (!has_vtk()) GTEST_SKIP() << "needs python3-vtk9";
  const Comparison fire(file, "t");
  ASSERT_EQ(fire.built().exit_code, 0) << fire.built().err;
  EXPECT_NE(fire.built().err.find("10,462 cells of a mesh became"), std::string::npos)
      << fire.built().err;
  for (const char* isovalue : {"350", "400", "500"}) {
    SCOPED_TRACE(isovalue);
    const Compared found = fire.at(isovalue);
    EXPECT_NEAR(found.area, 1, 0.01);
    EXPECT_LT(found.to_contour, 0.1);
    EXPECT_LT(found.to_surface, 0.1);
    EXPECT_LE(std::abs(found.components - found.expected_components), 1);
  }
}

/// Where the border is oblique, leaf cells that share an edge only have surfaces of their own, so
/// the numbers of components differ.
TEST(CliMeshContours, SurfacesOfGeneratedMeshesAreThoseOfVtk) {
  if (!has_vtk()) GTEST_SKIP() << "needs python3-vtk9";
  const TempFolder folder;
  const auto written =
      python({ISOSPLAT_SOURCE_DIR "/tests/native/write_meshes.py", folder.path().string()});
  ASSERT_EQ(written.exit_code, 0) << written.err;
  for (const char* name : {"curved.vts", "quadratic.vtu"}) {
    const Comparison mesh(folder / name, "t");
    ASSERT_EQ(mesh.built().exit_code, 0) << name << mesh.built().err;
    for (const char* isovalue : {"-0.3", "0.2", "0.7"}) {
      SCOPED_TRACE(name + std::string(" at ") + isovalue);
      const Compared found = mesh.at(isovalue);
      EXPECT_NEAR(found.area, 1, 0.02);
      EXPECT_LT(found.to_contour, 0.1);
      EXPECT_LT(found.to_surface, 0.2);
    }
  }
}

TEST(CliMeshContours, PointsOfTheFireLieOnTheContourOfVtk) {
  const auto volumes = test::volumes_folder();
  if (!volumes) GTEST_SKIP() << "needs volumes";
  const auto file = *volumes / "fire_ug.vtu";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  if (!has_vtk()) GTEST_SKIP() << "needs python3-vtk9";
  const TempFolder folder;
  for (const char* isovalue : {"303", "350", "400", "500"}) {
    const std::string points = folder / "points.vtp";
    const auto extracted =
        run({"extract", file.string(), "--dataset", "t", "-i", isovalue, "-o", points, "--force"});
    ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
    const auto ended = python({ISOSPLAT_SOURCE_DIR "/tests/native/compare_contours.py", "--points",
                               file.string(), "t", isovalue, points});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    std::istringstream numbers(ended.out);
    double mean = 1, most_are_below = 1, greatest = 1, back = 9;
    numbers >> mean >> most_are_below >> greatest >> back;
    std::cout << file.filename().string() << " at " << isovalue << ": " << ended.out;
    EXPECT_LT(mean, 0.05);
    EXPECT_LT(most_are_below, 0.2);
    EXPECT_LT(greatest, 0.6);
    EXPECT_LT(back, 1.5);
  }
}

}  // namespace
}  // namespace isosplat
