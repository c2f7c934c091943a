// Meshes of stores do not depend on the number of threads, and are closed across blocks and layers,
// on mirrored grids and at coarse levels. Mesh files contain the same triangles.
#include "native/extract/extract_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <set>

#include "native/builder/array_source.h"
#include "native/extract/encoded_file.h"
#include "native/extract/obj_file.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{90, 70, 140};
constexpr double kRadius = 28;
const Vec3d kCentre{45, 34.5, 66};

/// A ball that crosses blocks along every axis, and lies within the volume.
std::vector<uint16_t> ball() {
  std::vector<uint16_t> voxels;
  for (int32_t z = 0; z < kVoxels.z; ++z) {
    for (int32_t y = 0; y < kVoxels.y; ++y) {
      for (int32_t x = 0; x < kVoxels.x; ++x) {
        const double r = std::hypot(x - kCentre.x, y - kCentre.y, z - kCentre.z);
        voxels.push_back(static_cast<uint16_t>(std::max(0.0, 40000 - 400 * r)));
      }
    }
  }
  return voxels;
}
constexpr double kIsovalue = 40000 - 400 * kRadius;

class ExtractMesh : public testing::Test {
 protected:
  void open(const VolumeGrid& grid) {
    grid_ = grid;
    const auto path = folder_.path() / "ball.isosplat";
    ASSERT_TRUE(build_store_file<uint16_t>(grid, ball(), path));
    auto opened = StoreFile::open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    store_ = std::move(*opened);
  }

  MeshPart mesh(const ExtractOptions& options) {
    MeshPart all;
    const auto counts = extract_mesh(*store_, kIsovalue, options, [&](const MeshPart& part) {
      const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
      };
      append(all.vertices.positions, part.vertices.positions);
      append(all.vertices.normals, part.vertices.normals);
      append(all.triangles, part.triangles);
      return Result<void>{};
    });
    EXPECT_TRUE(counts) << counts.error().message;
    if (!counts) return all;
    EXPECT_EQ(counts->vertices, all.vertices.positions.size());
    EXPECT_EQ(counts->triangles, all.triangles.size());
    return all;
  }

  static void expect_closed(const MeshPart& mesh) {
    std::set<std::pair<uint32_t, uint32_t>> edges;
    for (const auto& t : mesh.triangles) {
      for (size_t i = 0; i < 3; ++i) {
        ASSERT_LT(t[i], mesh.vertices.positions.size());
        EXPECT_TRUE(edges.insert({t[i], t[(i + 1) % 3]}).second);
      }
    }
    for (const auto& [a, b] : edges) ASSERT_TRUE(edges.contains({b, a}));
    // Vertices − edges + triangles of a sphere.
    EXPECT_EQ(mesh.vertices.positions.size() + mesh.triangles.size() - edges.size() / 2, 2u);
  }

  static double volume_inside(const MeshPart& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto& at = mesh.vertices.positions;
      sum += dot(at[a], cross(at[b], at[c])) / 6;
    }
    return sum;
  }

  /// Expects that the normals point away from the ball's centre, to within this angle in degrees.
  void expect_normals(const MeshPart& mesh, double degrees) {
    const Vec3d centre = grid_.world(kCentre);
    for (size_t i = 0; i < mesh.vertices.positions.size(); ++i) {
      const Vec3d out = mesh.vertices.positions[i] - centre;
      const Vec3f n = mesh.vertices.normals[i];
      EXPECT_GT(dot(out, Vec3d{n.x, n.y, n.z}) / length(out),
                std::cos(degrees * std::numbers::pi / 180));
    }
  }

  TemporaryFolder folder_;
  VolumeGrid grid_;
  std::shared_ptr<StoreFile> store_;
};

const double kBall = 4.0 / 3 * std::numbers::pi * kRadius * kRadius * kRadius;

TEST_F(ExtractMesh, IsClosedAcrossBlocksAndTheSameForAnyThreads) {
  open({.voxels = kVoxels});
  const MeshPart one = mesh({.threads = 1}), three = mesh({.threads = 3});
  expect_closed(one);
  EXPECT_NEAR(volume_inside(one), kBall, 0.002 * kBall);
  expect_normals(one, 2);
  EXPECT_EQ(one.triangles, three.triangles);
  ASSERT_EQ(one.vertices.positions.size(), three.vertices.positions.size());
  const size_t count = one.vertices.positions.size();
  EXPECT_EQ(std::memcmp(one.vertices.positions.data(), three.vertices.positions.data(),
                        count * sizeof(Vec3d)),
            0);
  EXPECT_EQ(std::memcmp(one.vertices.normals.data(), three.vertices.normals.data(),
                        count * sizeof(Vec3f)),
            0);
}

TEST_F(ExtractMesh, IsOrientedOnMirroredGrids) {
  open({.voxels = kVoxels,
        .spacing = {0.5, 0.5, 0.5},
        .origin = {100, -50, 7},
        .direction = {0, 1, 0, 1, 0, 0, 0, 0, 1}});
  const MeshPart found = mesh({});
  expect_closed(found);
  EXPECT_NEAR(volume_inside(found), kBall / 8, 0.002 * kBall / 8);
  expect_normals(found, 2);
}

TEST_F(ExtractMesh, AtCoarseLevelsIsClosedAndNearTheSurface) {
  open({.voxels = kVoxels});
  for (const uint32_t level : {1u, 2u}) {
    const MeshPart found = mesh({.level = level});
    expect_closed(found);
    EXPECT_NEAR(volume_inside(found), kBall, 0.05 * level * kBall);
  }
}

TEST_F(ExtractMesh, HasNoTrianglesBeyondTheValues) {
  open({.voxels = kVoxels});
  const auto counts =
      extract_mesh(*store_, 1e9, {}, [](const MeshPart&) { return Result<void>{}; });
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->triangles, 0u);
}

/// The edges that belong to one triangle only.
std::vector<std::array<uint32_t, 2>> boundary_of(const MeshPart& mesh) {
  std::set<std::array<uint32_t, 2>> edges;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) edges.insert({t[i], t[(i + 1) % 3]});
  }
  std::vector<std::array<uint32_t, 2>> boundary;
  for (const auto& edge : edges) {
    if (!edges.contains({edge[1], edge[0]})) boundary.push_back(edge);
  }
  return boundary;
}

TEST_F(ExtractMesh, RegionsSideBySideAreTheWholeSurface) {
  // The axes have another order, and one is reversed, because the box is in world coordinates.
  open({.voxels = kVoxels,
        .spacing = {0.5, 1, 2},
        .origin = {10, 20, 30},
        .direction = {0, 0, 1, -1, 0, 0, 0, 1, 0}});
  const double cut = grid_.world({45, 0, 0}).y;
  const double far = 1e6;
  for (const uint32_t level : {0u, 1u}) {
    const MeshPart whole = mesh({.level = level});
    ExtractOptions options{.level = level};
    options.region = CellRegion::in_world(grid_, {-far, -far, -far}, {far, cut, far});
    const MeshPart left = mesh(options);
    options.region = CellRegion::in_world(grid_, {-far, cut, -far}, {far, far, far});
    const MeshPart right = mesh(options);
    EXPECT_GT(left.triangles.size(), whole.triangles.size() / 3);
    EXPECT_GT(right.triangles.size(), whole.triangles.size() / 3);
    EXPECT_EQ(left.triangles.size() + right.triangles.size(), whole.triangles.size());
    const auto boundary = boundary_of(left);
    EXPECT_EQ(boundary.size(), boundary_of(right).size());
    ASSERT_GT(boundary.size(), 50u);
    // The nearest face of cells is half a cell away at level 1.
    const double face = cut - (level == 0 ? 0 : 0.5);
    for (const auto& edge : boundary) {
      for (const uint32_t vertex : edge) EXPECT_EQ(left.vertices.positions[vertex].y, face);
    }
  }
}

TEST_F(ExtractMesh, RegionsHaveTheirPointsAtTheSamePositions) {
  open({.voxels = kVoxels});
  const auto points = [&](std::optional<CellRegion> region) {
    std::set<std::array<double, 3>> places;
    ExtractOptions options;
    options.region = region;
    const auto count = extract_points(*store_, kIsovalue, {}, options, [&](const PointArrays& all) {
      for (const Vec3d& at : all.positions) places.insert({at.x, at.y, at.z});
      return Result<void>{};
    });
    EXPECT_TRUE(count);
    EXPECT_EQ(*count, places.size());
    return places;
  };
  auto parts = points(CellRegion::in_grid({0, 0, 0}, {90, 70, 66.5}));
  const auto above = points(CellRegion::in_grid({0, 0, 66.5}, {90, 70, 140}));
  EXPECT_GT(parts.size(), 1000u);
  EXPECT_GT(above.size(), 1000u);
  parts.insert(above.begin(), above.end());
  EXPECT_EQ(parts, points({}));
}

TEST_F(ExtractMesh, EndsWithTheFirstErrorOfItsWriter) {
  open({.voxels = kVoxels});
  const auto counts = extract_mesh(*store_, kIsovalue, {}, [](const MeshPart&) -> Result<void> {
    return fail(Status::io_error, "the disk is full");
  });
  ASSERT_FALSE(counts);
  EXPECT_EQ(counts.error().message, "the disk is full");
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(ExtractMesh, PlyFilesHaveVerticesAndFaces) {
  open({.voxels = kVoxels});
  const auto path = folder_.path() / "ball.ply";
  auto file = EncodedFile::create(path, make_mesh_encoder(MeshFormatId::ply, grid_, "a ball"));
  ASSERT_TRUE(file);
  const auto counts = extract_mesh(*store_, kIsovalue, {},
                                   [&](const MeshPart& part) { return file->append(part); });
  ASSERT_TRUE(counts);
  ASSERT_TRUE(file->publish());
  const std::string content = content_of(path);
  EXPECT_NE(content.find("element face 0000"), std::string::npos);
  const size_t data = content.find("end_header\n") + 11;
  EXPECT_EQ(content.size(), data + 24 * counts->vertices + 13 * counts->triangles);
  EXPECT_EQ(content.size(), file->bytes());
  const MeshPart expected = mesh({});
  const char* faces = content.data() + data + 24 * counts->vertices;
  for (size_t i = 0; i < expected.triangles.size(); ++i) {
    ASSERT_EQ(faces[13 * i], 3);
    ASSERT_EQ(std::memcmp(faces + 13 * i + 1, &expected.triangles[i], 12), 0);
  }
}

TEST_F(ExtractMesh, StlFilesHaveEachTrianglesCorners) {
  open({.voxels = kVoxels});
  const auto path = folder_.path() / "ball.stl";
  auto file = EncodedFile::create(path, make_mesh_encoder(MeshFormatId::stl, grid_, "solid rock"));
  ASSERT_TRUE(file);
  const auto counts = extract_mesh(*store_, kIsovalue, {},
                                   [&](const MeshPart& part) { return file->append(part); });
  ASSERT_TRUE(counts);
  ASSERT_TRUE(file->publish());
  const std::string content = content_of(path);
  EXPECT_FALSE(content.starts_with("solid"));
  uint32_t count = 0;
  std::memcpy(&count, &content[80], 4);
  EXPECT_EQ(count, counts->triangles);
  ASSERT_EQ(content.size(), 84 + 50 * counts->triangles);
  const MeshPart expected = mesh({});
  for (size_t i = 0; i < expected.triangles.size(); ++i) {
    std::array<Vec3f, 4> stored;
    std::memcpy(stored.data(), &content[84 + 50 * i], sizeof stored);
    for (size_t k = 0; k < 3; ++k) {
      const Vec3d at = expected.vertices.positions[expected.triangles[i][k]];
      ASSERT_EQ(stored[k + 1].x, static_cast<float>(at.x));
      ASSERT_EQ(stored[k + 1].z, static_cast<float>(at.z));
    }
  }
}

TEST_F(ExtractMesh, ObjFilesCountFromOne) {
  open({.voxels = kVoxels});
  const auto path = folder_.path() / "ball.obj";
  auto file = ObjFile::create(path, {grid_, 1, "a ball"});
  ASSERT_TRUE(file);
  const auto counts = extract_mesh(*store_, kIsovalue, {},
                                   [&](const MeshPart& part) { return file->append(part); });
  ASSERT_TRUE(counts);
  ASSERT_TRUE(file->publish());
  std::ifstream lines(path);
  uint64_t vertices = 0, normals = 0, faces = 0, largest = 0;
  for (std::string line; std::getline(lines, line);) {
    vertices += line.starts_with("v ");
    normals += line.starts_with("vn ");
    if (!line.starts_with("f ")) continue;
    ++faces;
    unsigned a = 0, b = 0, c = 0, na = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "f %u//%u %u//%*u %u", &a, &na, &b, &c), 4);
    ASSERT_GE(std::min({a, b, c}), 1u);
    ASSERT_EQ(a, na);
    largest = std::max<uint64_t>({largest, a, b, c});
    ASSERT_LE(largest, vertices);
  }
  EXPECT_EQ(vertices, counts->vertices);
  EXPECT_EQ(normals, counts->vertices);
  EXPECT_EQ(faces, counts->triangles);
  EXPECT_EQ(largest, counts->vertices);
}

}  // namespace
}  // namespace isosplat
