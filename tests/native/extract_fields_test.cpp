// The values of fields at extracted points and vertices, compared with the source volumes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "native/builder/array_source.h"
#include "native/builder/store_with_fields.h"
#include "native/extract/extract_solid.h"
#include "native/extract/mesh_components.h"
#include "native/extract/simplify_mesh.h"
#include "tests/native/brute_force.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

constexpr Index3 kSize{90, 37, 70};  // two blocks along x and z, four levels
constexpr double kIsovalue = 140.25;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class T, class F>
std::vector<T> voxels_of(F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < kSize.z; ++z) {
    for (int32_t y = 0; y < kSize.y; ++y) {
      for (int32_t x = 0; x < kSize.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return voxels;
}

/// A field as it was before it was stored: its voxels and, at coarse levels, their averages.
class Source {
 public:
  Source(const FieldInfo& field, const std::vector<double>& values, uint32_t level)
      : level_(level) {
    if (level == 0) {
      cells_ = kSize - Index3{1, 1, 1};
      values_ = values;
      tolerance_ = field.mapping.max_error;
      return;
    }
    PlainLevel averages = plain_level_0(kSize, values, field.mapping);
    for (uint32_t l = 0; l < level; ++l) averages = plain_coarser(averages);
    cells_ = averages.cells;
    for (const int32_t voxel : averages.voxels) {
      values_.push_back(voxel < 0 ? kNaN : field.mapping.value(voxel));
    }
  }

  /// The greatest difference that the stored values and rounding allow.
  double tolerance() const {
    double most = 0;
    for (const double value : values_) {
      if (!std::isnan(value)) most = std::max(most, std::abs(value));
    }
    return tolerance_ * 1.001 + 3e-5 * most;
  }

  /// Whether the point lies on a face of cells.
  bool is_on_face(Vec3d point) const {
    const double size = std::ldexp(1.0, static_cast<int>(level_));
    const auto is_whole = [&](double x) {
      return std::abs(x / size - std::round(x / size)) < kRounding;
    };
    return is_whole(point.x) || is_whole(point.y) || is_whole(point.z);
  }

  /// The trilinear value at a point, in voxels of level 0; corners without weight do not count. Of
  /// a point of the cell: NaN if any of its corners is missing.
  double at(Vec3d point, bool needs_all) const {
    const double size = std::ldexp(1.0, static_cast<int>(level_));
    const auto axis = [&](double x, int32_t cells, int32_t& low) {
      // Positions were rounded: points on a lattice plane have two coordinates of its cells.
      double t = x / size;
      if (std::abs(t - std::round(t)) < kRounding) t = std::round(t);
      low = std::clamp(static_cast<int32_t>(std::floor(t)), 0, cells - 1);
      return t - low;
    };
    Index3 low;
    const double x = axis(point.x, cells_.x, low.x), y = axis(point.y, cells_.y, low.y),
                 z = axis(point.z, cells_.z, low.z);
    double sum = 0;
    for (int32_t k = 0; k < 8; ++k) {
      const double weight = (k & 1 ? x : 1 - x) * (k & 2 ? y : 1 - y) * (k & 4 ? z : 1 - z);
      if (weight == 0 && !needs_all) continue;
      const Index3 at = low + Index3{k & 1, k >> 1 & 1, k >> 2};
      sum += weight *
             values_[static_cast<size_t>((at.z * (cells_.y + 1) + at.y) * (cells_.x + 1) + at.x)];
    }
    return sum;
  }

 private:
  static constexpr double kRounding = 2e-5;

  uint32_t level_;
  Index3 cells_;
  std::vector<double> values_;
  double tolerance_ = 0;
};

class ExtractFields : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    grid_ = new VolumeGrid;
    grid_->voxels = kSize;
    const auto density = voxels_of<uint8_t>([](int x, int y, int z) {
      return 127 + 100 * std::sin(0.2 * x) * std::cos(0.15 * y + 0.1 * z);
    });
    values_ = new std::map<std::string, std::vector<double>>;
    (*values_)["small"] =
        voxels_of<double>([](int x, int y, int z) { return (x * 7 + y * 5 + z * 3) % 256; });
    (*values_)["real"] = voxels_of<double>([](int x, int y, int z) {
      return x > 80 || (x + 3 * y + 5 * z) % 97 == 0 ? kNaN
                                                     : 1e-3 * std::sin(0.1 * x + 0.2 * y) * z;
    });
    std::vector<FieldInput> inputs;
    for (const auto& [name, values] : *values_) {
      inputs.push_back({name, name + ".nrrd", [&values]() -> Result<std::unique_ptr<VolumeSource>> {
                          return std::make_unique<ArraySource<double>>(*grid_, values, "field", 1.0,
                                                                       0.0);
                        }});
    }
    const auto path = folder_->path() / "a.isosplat";
    ArraySource<uint8_t> source(*grid_, density, "density");
    const auto built = build_store_with_fields(source, inputs, path, {});
    ASSERT_TRUE(built) << built.error().message;
    auto store = StoreFile::open(path);
    ASSERT_TRUE(store) << store.error().message;
    store_ = new std::shared_ptr<StoreFile>(std::move(*store));
  }

  static void TearDownTestSuite() {
    delete store_;
    delete values_;
    delete grid_;
    delete folder_;
  }

  static ExtractOptions with_fields(uint32_t level, const std::vector<std::string>& names,
                                    unsigned threads = 2) {
    ExtractOptions options{level, threads};
    auto fields = open_fields(**store_, names);
    EXPECT_TRUE(fields) << fields.error().message;
    options.fields = std::move(*fields);
    return options;
  }

  static MeshPart mesh_of(const ExtractOptions& options) {
    MeshPart mesh;
    const auto done = extract_mesh(**store_, kIsovalue, options, [&](const MeshPart& part) {
      append_part(mesh, part);
      return Result<void>{};
    });
    EXPECT_TRUE(done) << done.error().message;
    return mesh;
  }

  /// Compares all values at points with those of the source. Returns how many are known.
  static size_t expect_values(const PointsWithFields& points, const ExtractOptions& options,
                              bool needs_all) {
    size_t known = 0;
    EXPECT_EQ(points.fields.size(), options.fields.size());
    for (size_t f = 0; f < points.fields.size(); ++f) {
      const FieldInfo& info = *options.fields[f]->info().field;
      const Source source(info, values_->at(info.name), options.level);
      const double tolerance = source.tolerance();
      EXPECT_EQ(points.fields[f].size(), points.positions.size());
      for (size_t i = 0; i < points.positions.size(); ++i) {
        const bool is_shared = needs_all && source.is_on_face(points.positions[i]);
        const double expected = source.at(points.positions[i], needs_all && !is_shared);
        const double found = points.fields[f][i];
        if (is_shared && std::isnan(found)) continue;  // in either of two cells
        if (std::isnan(expected) || std::isnan(found)) {
          EXPECT_EQ(std::isnan(expected), std::isnan(found)) << info.name << " " << i;
        } else {
          EXPECT_NEAR(found, expected, tolerance) << info.name << " " << i;
          ++known;
        }
        if (HasFailure()) return known;
      }
    }
    return known;
  }

  static TemporaryFolder* folder_;
  static VolumeGrid* grid_;
  static std::map<std::string, std::vector<double>>* values_;
  static std::shared_ptr<StoreFile>* store_;
};

TemporaryFolder* ExtractFields::folder_ = nullptr;
VolumeGrid* ExtractFields::grid_ = nullptr;
std::map<std::string, std::vector<double>>* ExtractFields::values_ = nullptr;
std::shared_ptr<StoreFile>* ExtractFields::store_ = nullptr;

TEST_F(ExtractFields, PointsHaveTheTrilinearValuesOfTheirCells) {
  for (const uint32_t level : {0u, 1u, 2u}) {
    for (const bool smooth : {true, false}) {
      SCOPED_TRACE(testing::Message() << "level " << level << ", smooth " << smooth);
      ExtractOptions options = with_fields(level, {"real", "small"});
      options.smooth_normals = smooth;
      PointsWithFields all;
      const auto count =
          extract_points(**store_, kIsovalue, {}, options, [&](const PointsWithFields& points) {
            all.positions.insert(all.positions.end(), points.positions.begin(),
                                 points.positions.end());
            append_values(all.fields, points.fields);
            return Result<void>{};
          });
      ASSERT_TRUE(count) << count.error().message;
      const size_t known = expect_values(all, options, true);
      EXPECT_GT(known, *count);
      EXPECT_LT(known, 2 * *count) << "some values are missing";
    }
  }
}

TEST_F(ExtractFields, VerticesHaveTheValuesOnTheirEdges) {
  for (const uint32_t level : {0u, 1u, 2u}) {
    SCOPED_TRACE(testing::Message() << "level " << level);
    const ExtractOptions options = with_fields(level, {"small", "real"});
    const MeshPart mesh = mesh_of(options);
    const size_t known = expect_values(mesh.vertices, options, false);
    EXPECT_GT(known, mesh.vertices.positions.size());
    EXPECT_LT(known, 2 * mesh.vertices.positions.size()) << "some values are missing";
  }
}

TEST_F(ExtractFields, DoNotDependOnThreadsAndRegions) {
  ExtractOptions options = with_fields(0, {"small"}, 1);
  const MeshPart one = mesh_of(options);
  const MeshPart three = mesh_of(with_fields(0, {"small"}, 3));
  EXPECT_EQ(one.vertices.fields, three.vertices.fields);
  // A part of the cells of chunks: field chunks are decoded with all of them.
  options.region = CellRegion::in_grid({20, 3, 10}, {75, 30, 66});
  const MeshPart part = mesh_of(options);
  EXPECT_GT(part.vertices.positions.size(), 1000u);
  EXPECT_LT(part.vertices.positions.size(), one.vertices.positions.size());
  expect_values(part.vertices, options, false);
}

TEST_F(ExtractFields, LayersWithoutTheFieldHaveNoValues) {
  ExtractOptions options = with_fields(0, {"small"});
  options.fields.push_back(nullptr);
  const MeshPart mesh = mesh_of(options);
  ASSERT_EQ(mesh.vertices.fields.size(), 2u);
  EXPECT_EQ(mesh.vertices.fields[1].size(), mesh.vertices.positions.size());
  EXPECT_TRUE(std::ranges::all_of(mesh.vertices.fields[1], [](float v) { return std::isnan(v); }));
}

TEST_F(ExtractFields, ChangedMeshesKeepTheValuesOfTheirVertices) {
  const ExtractOptions options = with_fields(0, {"real"});
  MeshPart mesh = mesh_of(options);
  const size_t before = mesh.vertices.positions.size();
  EXPECT_GT(keep_largest_components(mesh, 1), 1u);
  expect_values(mesh.vertices, options, false);
  ASSERT_TRUE(simplify_mesh(mesh, 0.2));
  EXPECT_LT(mesh.vertices.positions.size(), before / 2);
  EXPECT_GT(expect_values(mesh.vertices, options, false), 100u);
}

/// Vertices of cuts are up to 2⁻¹⁴ voxels beside their plane: see clip_closed().
bool is_on(double at, double plane) {
  return std::abs(at - plane) < 1e-4;
}

TEST_F(ExtractFields, ClosedSurfacesHaveValuesOnTheIsosurface) {
  const ExtractOptions options = with_fields(0, {"small"});
  const Vec3d low{10.5, 3.25, 8.5}, high{77.75, 33.5, 65.5};
  const auto solid = extract_solid(**store_, kIsovalue, options,
                                   {.box = {{low, high}}, .planes = {{{1, 1, 0}, 30}}});
  ASSERT_TRUE(solid) << solid.error().message;
  const PointsWithFields& vertices = solid->vertices;
  const auto& values = vertices.fields[0];
  ASSERT_EQ(values.size(), vertices.positions.size());
  // Where triangles were cut, values are between those of the cell. Inside of caps they are
  // unknown.
  const Source source(*options.fields[0]->info().field, values_->at("small"), 0);
  const double tolerance = source.tolerance();
  /// A bit for each plane of a cut that contains the point.
  const auto planes_of = [&](Vec3d at) {
    return is_on(at.x, low.x) | is_on(at.x, high.x) << 1 | is_on(at.y, low.y) << 2 |
           is_on(at.y, high.y) << 3 | is_on(at.z, low.z) << 4 | is_on(at.z, high.z) << 5 |
           is_on(at.x + at.y, 30) << 6;
  };
  size_t uncut = 0, cut = 0, unknown = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const Vec3d at = vertices.positions[i];
    const bool is_cut = planes_of(at) != 0;
    if (std::isnan(values[i])) {
      EXPECT_TRUE(is_cut) << i;
      ++unknown;
    } else if (!is_cut) {
      EXPECT_NEAR(values[i], source.at(at, false), tolerance) << i;
      ++uncut;
    } else {
      double least = HUGE_VAL, most = -HUGE_VAL;
      for (int k = 0; k < 8; ++k) {
        const auto corner = [&](double x, int bit) {
          return bit ? std::floor(x) + 1 : std::floor(x);
        };
        const double value =
            source.at({corner(at.x, k & 1), corner(at.y, k >> 1 & 1), corner(at.z, k >> 2)}, false);
        least = std::min(least, value);
        most = std::max(most, value);
      }
      EXPECT_GE(values[i], least - 0.01) << i;
      EXPECT_LE(values[i], most + 0.01) << i;
      ++cut;
    }
  }
  EXPECT_GT(uncut, 1000u);
  EXPECT_GT(cut, 500u);
  EXPECT_GT(unknown, 0u);
  // All vertices of triangles outside of the planes are known.
  for (const auto& [a, b, c] : solid->triangles) {
    const auto& at = vertices.positions;
    if ((planes_of(at[a]) & planes_of(at[b]) & planes_of(at[c])) != 0) continue;
    ASSERT_FALSE(std::isnan(values[a]) || std::isnan(values[b]) || std::isnan(values[c]));
  }
}

TEST_F(ExtractFields, RefusesUnknownNames) {
  const std::vector<std::string> unknown{"small", "temperature"};
  const auto fields = open_fields(**store_, unknown);
  ASSERT_FALSE(fields);
  EXPECT_EQ(fields.error().status, Status::not_found);
  EXPECT_NE(fields.error().message.find("a.isosplat: field 'temperature'"), std::string::npos);
  EXPECT_NE(fields.error().message.find("real, small"), std::string::npos)
      << fields.error().message;
  const std::vector<std::string> twice{"small", "small"};
  EXPECT_EQ(open_fields(**store_, twice).error().status, Status::invalid_argument);
}

}  // namespace
}  // namespace isosplat
