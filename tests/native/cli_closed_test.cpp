// isosplat extract --mesh --closed: surfaces without open edges, by the file's bytes and by VTK.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_file;

constexpr double kPi = std::numbers::pi;

using Corner = std::array<float, 3>;

/// The triangles of a binary STL file.
struct Stl {
  std::vector<std::array<Corner, 3>> triangles;

  explicit Stl(const std::string& path) {
    const std::string file = read_file(path);
    uint32_t count = 0;
    EXPECT_GE(file.size(), 84u);
    std::memcpy(&count, file.data() + 80, 4);
    EXPECT_EQ(file.size(), 84 + 50 * size_t{count});
    triangles.resize(count);
    for (size_t i = 0; i < count; ++i) {
      std::memcpy(triangles[i].data(), file.data() + 84 + 50 * i + 12, 36);
    }
  }

  double volume() const {
    double six = 0;
    for (const auto& [a, b, c] : triangles) {
      six += double{a[0]} * (double{b[1]} * c[2] - double{b[2]} * c[1]) +
             double{a[1]} * (double{b[2]} * c[0] - double{b[0]} * c[2]) +
             double{a[2]} * (double{b[0]} * c[1] - double{b[1]} * c[0]);
    }
    return six / 6;
  }

  /// Edges that are not used as often in one direction as in the other.
  size_t open_edges() const {
    std::map<std::pair<Corner, Corner>, int> surplus;
    for (const auto& t : triangles) {
      for (size_t i = 0; i < 3; ++i) {
        const auto& a = t[i];
        const auto& b = t[(i + 1) % 3];
        if (a != b) surplus[std::minmax(a, b)] += a < b ? 1 : -1;
      }
    }
    return static_cast<size_t>(
        std::ranges::count_if(surplus, [](const auto& edge) { return edge.second != 0; }));
  }
};

/// A store of a ball with radius 24 around (20, 25.3, 24.7), which the border at x = 0 cuts.
/// `missing`: one voxel at the surface has no value.
std::string build_ball(const TempFolder& folder, bool missing = false) {
  std::vector<float> voxels;
  for (int z = 0; z < 50; ++z) {
    for (int y = 0; y < 52; ++y) {
      for (int x = 0; x < 48; ++x) {
        voxels.push_back(static_cast<float>(24 - std::hypot(x - 20, y - 25.3, z - 24.7)));
      }
    }
  }
  if (missing) voxels[size_t(20 + 48 * (25 + 52 * 1))] = std::nanf("");
  const std::string name = missing ? "missing" : "ball";
  write_file(folder / (name + ".raw"), test::bytes_of(voxels));
  const Ended built = run({"build", folder / (name + ".raw"), "--dims", "48x52x50", "--type", "f32",
                           "--spacing", "0.5,0.5,0.5", "-q"});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  return folder / (name + ".isosplat");
}

/// The volume of a ball of radius r up to a distance from its centre.
double ball_below(double r, double distance) {
  const double h = r + distance;
  return kPi * h * h * (3 * r - h) / 3;
}

class CliClosed : public testing::Test {
 protected:
  Ended extract(const std::string& store, const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> arguments{"extract", store, "-i",        "0.001",
                                       "--mesh",  "-o",  out_ / name, "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  TempFolder out_;
};

TEST_F(CliClosed, SurfacesAreClosedAtBordersBoxesAndPlanes) {
  const std::string store = build_ball(out_);
  const double scale = 0.125;  // of a voxel, in mm³
  struct Case {
    std::vector<std::string> arguments;
    double volume;
  };
  const double whole = ball_below(24, 20) * scale;
  const std::string half_plane = "1,2,2," + std::to_string(10 + 2 * 12.65 + 2 * 12.35);
  for (const auto& [arguments, volume] : {
           Case{{}, whole},
           Case{{"--box", "-1,-1,-1,13.1,99,99"},
                (ball_below(24, 20) + ball_below(24, 6.2) - ball_below(24, 24)) * scale},
           Case{{"--clip-plane", "1,0,0,4.55"}, ball_below(24, 10.9) * scale},
           Case{{"--clip-plane", "1,0,0,4.55", "--clip-plane=-1,0,0,-13.1"},
                (ball_below(24, 10.9) + ball_below(24, 6.2) - ball_below(24, 24)) * scale},
       }) {
    const Ended written = extract(store, "a.stl", arguments);
    ASSERT_EQ(written.exit_code, 0) << written.err;
    const Stl stl(out_ / "a.stl");
    EXPECT_EQ(stl.open_edges(), 0u);
    EXPECT_NEAR(stl.volume() / volume, 1, 2e-3) << volume;
  }
  // Both sides of an oblique plane.
  double sum = 0;
  for (const std::string& plane : {half_plane, "-1,-2,-2,-" + half_plane.substr(6)}) {
    ASSERT_EQ(extract(store, "half.stl", {"--clip-plane=" + plane}).exit_code, 0);
    const Stl half(out_ / "half.stl");
    EXPECT_EQ(half.open_edges(), 0u);
    sum += half.volume();
  }
  ASSERT_EQ(extract(store, "a.stl", {}).exit_code, 0);
  EXPECT_NEAR(sum / Stl(out_ / "a.stl").volume(), 1, 1e-5);
}

TEST_F(CliClosed, TheFormatAndTheOptionsChooseWhetherASurfaceIsClosed) {
  const std::string store = build_ball(out_);
  ASSERT_EQ(extract(store, "closed.stl", {"--closed"}).exit_code, 0);
  ASSERT_EQ(extract(store, "default.stl", {}).exit_code, 0);
  ASSERT_EQ(extract(store, "open.stl", {"--open"}).exit_code, 0);
  EXPECT_EQ(read_file(out_ / "closed.stl"), read_file(out_ / "default.stl"));
  EXPECT_GT(Stl(out_ / "open.stl").open_edges(), 50u);
  for (const char* name : {"a.3mf", "a.ply", "a.obj", "a.glb", "a.npz"}) {
    const bool is_solid = std::string(name) == "a.3mf";
    ASSERT_EQ(extract(store, name, {}).exit_code, 0);
    const std::string by_default = read_file(out_ / name);
    ASSERT_EQ(extract(store, name, {is_solid ? "--closed" : "--open"}).exit_code, 0);
    EXPECT_EQ(read_file(out_ / name), by_default) << name;
    ASSERT_EQ(extract(store, name, {is_solid ? "--open" : "--closed"}).exit_code, 0);
    EXPECT_NE(read_file(out_ / name), by_default) << name;
  }
}

TEST_F(CliClosed, SimplifiedSolidsStayClosed) {
  const std::string store = build_ball(out_);
  ASSERT_EQ(extract(store, "a.stl", {"--clip-plane", "1,2,2,60", "--simplify", "0.05"}).exit_code,
            0);
  const Stl stl(out_ / "a.stl");
  EXPECT_EQ(stl.open_edges(), 0u);
  EXPECT_GT(stl.volume(), 100);
}

TEST_F(CliClosed, MissingVoxelsLeaveASurfaceOpenOrAreAnError) {
  const std::string store = build_ball(out_, true);
  const Ended by_default = extract(store, "a.stl", {});
  EXPECT_EQ(by_default.exit_code, 0);
  EXPECT_NE(by_default.err.find("the surface is open: missing voxels"), std::string::npos)
      << by_default.err;
  ASSERT_EQ(extract(store, "open.stl", {"--open"}).exit_code, 0);
  EXPECT_EQ(read_file(out_ / "a.stl"), read_file(out_ / "open.stl"));
  for (const std::vector<std::string>& how :
       {std::vector<std::string>{"--closed"}, {"--clip-plane", "1,0,0,2"}}) {
    const Ended refused = extract(store, "b.stl", how);
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_NE(refused.err.find("holes"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(out_ / "b.stl"));
  }
  // The hole is cut off.
  ASSERT_EQ(extract(store, "c.stl", {"--closed", "--box", "-1,-1,8,99,99,99"}).exit_code, 0);
  EXPECT_EQ(Stl(out_ / "c.stl").open_edges(), 0u);
}

TEST_F(CliClosed, RefusesWrongPlanes) {
  const std::string store = build_ball(out_);
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--clip-plane", "0,0,0,1"},
                                                {"--clip-plane", "1,2,3"},
                                                {"--clip-plane", "nan,0,0,1"},
                                                {"--clip-plane", "1e-320,0,0,1e308"},
                                                {"--clip-plane", "1,0,0,5", "--open"},
                                                {"--closed", "--open"}}) {
    const Ended refused = extract(store, "a.stl", wrong);
    EXPECT_NE(refused.exit_code, 0) << wrong[1];
    EXPECT_FALSE(refused.err.empty());
    EXPECT_FALSE(std::filesystem::exists(out_ / "a.stl"));
  }
  EXPECT_EQ(extract(store, "a.ply", {"--clip-plane", "1,0,0,5"}).exit_code, 2);
}

TEST_F(CliClosed, VtkFindsNoOpenEdges) {
  const std::string python = "/usr/bin/python3";
  if (std::system((python + " -c 'import vtkmodules.vtkIOGeometry' 2>/dev/null").c_str()) != 0) {
    GTEST_SKIP() << "python3-vtk9 is not installed";
  }
  const std::string store = build_ball(out_);
  ASSERT_EQ(extract(store, "a.stl", {"--clip-plane", "1,2,2,60.1"}).exit_code, 0);
  write_file(out_ / "check.py", R"(import sys
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkMassProperties
from vtkmodules.vtkIOGeometry import vtkSTLReader
reader = vtkSTLReader()
reader.SetFileName(sys.argv[1])
edges = vtkFeatureEdges()
edges.BoundaryEdgesOn()
edges.NonManifoldEdgesOn()
edges.FeatureEdgesOff()
edges.ManifoldEdgesOff()
edges.SetInputConnection(reader.GetOutputPort())
edges.Update()
mass = vtkMassProperties()
mass.SetInputConnection(reader.GetOutputPort())
mass.Update()
print(edges.GetOutput().GetNumberOfCells(), mass.GetVolume())
)");
  const std::string command = python + " " + std::string(out_ / "check.py") + " " +
                              std::string(out_ / "a.stl") + " > " + std::string(out_ / "found");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string found = read_file(out_ / "found");
  const size_t blank = found.find(' ');
  ASSERT_NE(blank, std::string::npos);
  EXPECT_EQ(found.substr(0, blank), "0");
  EXPECT_NEAR(std::stod(found.substr(blank)) / Stl(out_ / "a.stl").volume(), 1, 1e-3);
}

}  // namespace
}  // namespace isosplat
