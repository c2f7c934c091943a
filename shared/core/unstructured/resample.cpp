#include "shared/core/unstructured/resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/unstructured/border_values.h"
#include "shared/core/unstructured/boundary_faces.h"
#include "shared/core/unstructured/box_triangle.h"
#include "shared/core/unstructured/level_plan.h"
#include "shared/core/unstructured/random_points.h"

namespace isosplat {
namespace {

/// Boxes of grid cells are larger by this share for cells of the mesh, and smaller for its border,
/// so that cells that only touch the border are inside.
constexpr double kMargin = 1e-5;
/// Edges that are equal but for rounding.
constexpr double kSameEdge = 1.001;
/// Values that are equal but for rounding, as a share of the largest one.
constexpr double kRounding = 1e-12;
constexpr int32_t kRandomPoints = 16;
constexpr size_t kMostMeshPoints = 64;  ///< that are compared in one grid cell
/// Boundary faces look at each other if the cosine between their normals is below.
constexpr double kOpposite = -0.7;
/// How far around a grid cell gaps are searched, in edges.
constexpr double kGapMargin = 0.6;

/// A cell of the mesh near a grid cell.
struct Candidate {
  uint32_t cell = 0;
  Box box;  ///< with a margin
};

struct GridCell {
  uint32_t level = 0;
  Index3 at;
  Box box;
  double edge = 0;  ///< the longest one
};

Vec3d corner_of(const Box& box, int32_t octant) {
  return {octant & 1 ? box.high.x : box.low.x, octant & 2 ? box.high.y : box.low.y,
          octant & 4 ? box.high.z : box.low.z};
}

/// A position from 0 to 1 in a box.
Vec3d in_box(const Box& box, Vec3d f) {
  const Vec3d size = box.high - box.low;
  return box.low + Vec3d{size.x * f.x, size.y * f.y, size.z * f.z};
}

Vec3d fraction_in(const Box& box, Vec3d p) {
  const Vec3d size = box.high - box.low, d = p - box.low;
  return {d.x / size.x, d.y / size.y, d.z / size.z};
}

double interpolated(const std::array<double, 8>& values, Vec3d f) {
  const auto along = [](double a, double b, double t) { return a + (b - a) * t; };
  const auto row = [&](size_t i) { return along(values[i], values[i + 1], f.x); };
  const auto face = [&](size_t i) { return along(row(i), row(i + 2), f.y); };
  return along(face(0), face(4), f.z);
}

class Resampler {
 public:
  Resampler(const UnstructuredMesh& mesh, MeshSurvey survey, const LevelPlan& plan, double limit,
            AdaptiveGrid grid)
      : mesh_(mesh),
        survey_(std::move(survey)),
        plan_(plan),
        limit_(limit),
        grid_(std::move(grid)) {}

  Result<void> run(const Bins& cells, const std::vector<BoundaryFace>& faces,
                   const Bins& face_bins);
  AdaptiveGrid take() { return std::move(grid_); }

 private:
  using Candidates = std::vector<Candidate>;
  using Faces = std::vector<BoundaryFace>;

  GridCell grid_cell(uint32_t level, Index3 at) const;
  Result<void> visit(const GridCell& cell, const Candidates& near, const Faces& near_faces);
  Result<void> split(const GridCell& cell, const Candidates& near, const Faces& near_faces);
  bool crosses(const BoundaryFace& face, const Box& box) const;
  std::optional<Located> find(const Candidates& near, Vec3d point) const;
  bool has_gap(const GridCell& cell, const Faces& near_faces) const;
  double error(const GridCell& cell, const Candidates& near, const std::array<double, 8>& values,
               float& size) const;

  const UnstructuredMesh& mesh_;
  MeshSurvey survey_;
  LevelPlan plan_;
  double limit_;
  AdaptiveGrid grid_;
};

GridCell Resampler::grid_cell(uint32_t level, Index3 at) const {
  const double share = 1.0 / grid_.cells_per_edge(0, level);
  const Vec3d spacing = plan_.spacing * share;
  const auto node = [&](Index3 i) {
    return plan_.origin + Vec3d{spacing.x * i.x, spacing.y * i.y, spacing.z * i.z};
  };
  return {level,
          at,
          {node(at), node(at + Index3{1, 1, 1})},
          std::max({spacing.x, spacing.y, spacing.z})};
}

/// A face of four corners need not be plane: it lies between the triangles of both diagonals.
bool Resampler::crosses(const BoundaryFace& face, const Box& box) const {
  const FaceCorners corners = corners_of(mesh_, face);
  const auto& p = corners.at;
  if (overlap(box, {p[0], p[1], p[2]})) return true;
  return corners.count == 4 &&
         (overlap(box, {p[0], p[2], p[3]}) || overlap(box, {p[0], p[1], p[3]}) ||
          overlap(box, {p[1], p[2], p[3]}));
}

std::optional<Located> Resampler::find(const Candidates& near, Vec3d point) const {
  for (const Candidate& each : near) {
    if (!each.box.contains(point)) continue;
    if (const auto weights = weights_in_cell(mesh_.geometry(each.cell), point)) {
      return Located{each.cell, mesh_.value(each.cell, *weights)};
    }
  }
  return std::nullopt;
}

/// Whether two boundary faces in or near a grid cell look at each other. Half an edge around it is
/// searched too: the border of two grid cells may lie in a gap.
bool Resampler::has_gap(const GridCell& cell, const Faces& near_faces) const {
  struct Plane {
    Vec3d normal;
    double distance;  ///< of the grid cell's centre
  };
  const Vec3d around = (cell.box.high - cell.box.low) * kGapMargin;
  const Box box{cell.box.low - around, cell.box.high + around};
  const Vec3d centre = (box.low + box.high) * 0.5;
  std::vector<Plane> planes;
  for (const BoundaryFace& face : near_faces) {
    if (!crosses(face, box)) continue;
    const Vec3d normal = outward_normal(mesh_, face);
    const Plane plane{normal, dot(centre - corners_of(mesh_, face).at[0], normal)};
    for (const Plane& other : planes) {
      // The sum is the width of the gap. It is negative for a thin sheet of the mesh.
      if (dot(normal, other.normal) < kOpposite && plane.distance + other.distance >= 0)
        return true;
    }
    planes.push_back(plane);
  }
  return false;
}

/// The largest error at points of the mesh and at random points in a grid cell. `size`: becomes the
/// smallest size of the mesh's cells there.
double Resampler::error(const GridCell& cell, const Candidates& near,
                        const std::array<double, 8>& values, float& size) const {
  double most = 0;
  const auto compare = [&](Vec3d f, double expected) {
    most = std::max(most, std::abs(interpolated(values, f) - expected));
  };
  size_t points = 0;
  for (const Candidate& each : near) {
    for (const uint32_t point : mesh_.corners_of(each.cell)) {
      const Vec3d at = mesh_.points[point];
      if (points >= kMostMeshPoints || !cell.box.contains(at)) continue;
      compare(fraction_in(cell.box, at), mesh_.values[point]);
      size = std::min(size, survey_.sizes[each.cell]);
      ++points;
    }
  }
  const uint64_t seed = (uint64_t{cell.level} << 60) ^ static_cast<uint64_t>(cell.at.x) ^
                        static_cast<uint64_t>(cell.at.y) << 20 ^
                        static_cast<uint64_t>(cell.at.z) << 40;
  RandomPoints random(seed);
  for (int32_t i = 0; i < kRandomPoints; ++i) {
    const Vec3d f = random.in_unit_cube();
    const auto found = find(near, in_box(cell.box, f));
    if (!found) continue;
    compare(f, found->value);
    size = std::min(size, survey_.sizes[found->cell]);
  }
  return most;
}

Result<void> Resampler::split(const GridCell& cell, const Candidates& near,
                              const Faces& near_faces) {
  for (int32_t i = 0; i < 8; ++i) {
    const Index3 child = cell.at * 2 + Index3{i & 1, i >> 1 & 1, i >> 2};
    if (auto done = visit(grid_cell(cell.level + 1, child), near, near_faces); !done) return done;
  }
  return {};
}

Result<void> Resampler::visit(const GridCell& cell, const Candidates& near,
                              const Faces& near_faces) {
  Candidates own;
  const bool is_finest = cell.level == plan_.finer;
  bool is_larger = false;  // than a cell of the mesh whose centre lies in it
  for (const Candidate& each : near) {
    if (!each.box.overlaps(cell.box)) continue;
    own.push_back(each);
    is_larger |= cell.edge > survey_.sizes[each.cell] * kSameEdge &&
                 cell.box.contains((each.box.low + each.box.high) * 0.5);
  }
  if (own.empty()) return {};
  Faces faces;  // in the grid cell, or so near that they matter for gaps in it or its parts
  bool is_crossed = false;
  const Vec3d around = (cell.box.high - cell.box.low) * kGapMargin;
  const Box wide{cell.box.low - around, cell.box.high + around};
  const Vec3d shrink = (cell.box.high - cell.box.low) * kMargin;
  const Box within{cell.box.low + shrink, cell.box.high - shrink};
  for (const BoundaryFace& face : near_faces) {
    if (!crosses(face, wide)) continue;
    faces.push_back(face);
    is_crossed = is_crossed || crosses(face, within);
  }
  if (is_larger && !is_finest) return split(cell, own, faces);

  std::array<std::optional<Located>, 8> corners;
  float size = std::numeric_limits<float>::max();
  size_t found = 0;
  for (int32_t i = 0; i < 8; ++i) {
    auto& corner = corners[static_cast<size_t>(i)];
    corner = find(own, corner_of(cell.box, i));
    if (!corner) continue;
    ++found;
    size = std::min(size, survey_.sizes[corner->cell]);
  }
  // A hole that is as large as the grid cell has all corners, but not the centre, in other cells.
  const bool is_hole = found == 8 && !find(own, (cell.box.low + cell.box.high) * 0.5);
  const bool is_border = is_crossed || is_hole || (found > 0 && found < 8);
  if (found == 0 && !is_border) return {};
  if (found == 0) {
    for (const Candidate& each : own) size = std::min(size, survey_.sizes[each.cell]);
  }
  const auto is_above = [&](double share) {
    return !is_finest && cell.edge > size * share * kSameEdge;
  };
  if (is_above(is_border ? kBorderShare : 1)) return split(cell, own, faces);

  std::array<double, 8> values{};
  if (is_border) {
    if (has_gap(cell, faces)) return {};
    std::array<std::optional<double>, 8> known;
    for (size_t i = 0; i < 8; ++i) {
      if (corners[i]) known[i] = corners[i]->value;
    }
    const auto border = border_values(cell.box, known, [&](Vec3d point) {
      const auto located = find(own, point);
      return located ? std::optional(located->value) : std::nullopt;
    });
    if (!border) return {};
    values = *border;
  } else {
    for (size_t i = 0; i < 8; ++i) values[i] = corners[i]->value;
  }
  const bool is_wrong = error(cell, own, values, size) > limit_;
  if (is_above(is_border ? kBorderShare : 1) || (is_wrong && is_above(kFinestShare * 2))) {
    return split(cell, own, faces);
  }
  return grid_.add(cell.level, {cell.at, cell.at + Index3{1, 1, 1}}, values);
}

Result<void> Resampler::run(const Bins& cells, const std::vector<BoundaryFace>& faces,
                            const Bins& face_bins) {
  const auto gather = [](const Bins& bins, const Box& box) {
    std::vector<uint32_t> items;
    const Index3 low = bins.grid().bin_of(box.low), high = bins.grid().bin_of(box.high);
    for (int32_t z = low.z; z <= high.z; ++z) {
      for (int32_t y = low.y; y <= high.y; ++y) {
        for (int32_t x = low.x; x <= high.x; ++x) {
          const auto some = bins.items({x, y, z});
          items.insert(items.end(), some.begin(), some.end());
        }
      }
    }
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
    return items;
  };
  const Index3 n = plan_.cells;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const GridCell cell = grid_cell(0, {x, y, z});
        Candidates near;
        for (const uint32_t item : gather(cells, cell.box)) {
          Box box = box_of(mesh_.geometry(item));
          const Vec3d margin = (box.high - box.low) * kMargin;
          near.push_back({item, {box.low - margin, box.high + margin}});
        }
        Faces near_faces;
        const Vec3d around = (cell.box.high - cell.box.low) * kGapMargin;
        const Box wide{cell.box.low - around, cell.box.high + around};
        for (const uint32_t item : gather(face_bins, wide)) near_faces.push_back(faces[item]);
        if (auto done = visit(cell, near, near_faces); !done) return done;
      }
    }
  }
  return {};
}

tl::unexpected<Error> too_large(uint64_t bytes) {
  return fail(Status::out_of_memory,
              "an unstructured grid: expected a grid of at most " + std::to_string(bytes >> 20) +
                  " MiB, found more: raise --memory, or accept a larger --max-error");
}

}  // namespace

Result<ResampledMesh> resample(const UnstructuredMesh& mesh, const ResampleOptions& options) {
  auto survey = survey_mesh(mesh);
  if (!survey) return tl::unexpected(survey.error());
  const LevelPlan plan = plan_levels(*survey, kFinestShare, kMostLatticeVoxels);
  const BinGrid bin_grid = plan_bins(*survey);
  const auto cell_box = [&](size_t cell) -> std::optional<Box> {
    if (!(survey->sizes[cell] > 0)) return std::nullopt;
    return box_of(mesh.geometry(cell));
  };
  const auto cells = Bins::create(bin_grid, mesh.cells(), cell_box, options.memory_bytes / 2);
  if (!cells) return tl::unexpected(cells.error());
  uint64_t left = options.memory_bytes - cells->memory_bytes();
  const auto faces = boundary_faces(mesh, *cells, survey->sizes, left);
  if (!faces) return tl::unexpected(faces.error());
  const auto face_box = [&](size_t face) -> std::optional<Box> {
    const FaceCorners corners = corners_of(mesh, (*faces)[face]);
    Box box{corners.at[0], corners.at[0]};
    for (size_t i = 1; i < corners.count; ++i) box.add(corners.at[i]);
    return box;
  };
  left -=
      std::min<uint64_t>(left, faces->size() * sizeof(BoundaryFace) + mesh.cells() * sizeof(float));
  const auto face_bins = Bins::create(bin_grid, faces->size(), face_box, left / 2);
  if (!face_bins) return tl::unexpected(face_bins.error());
  left -= face_bins->memory_bytes();

  const double range = survey->high - survey->low;
  // A constant field would otherwise be refined because of rounding.
  const double rounding = kRounding * std::max(std::abs(survey->low), std::abs(survey->high));
  const double limit =
      options.max_error > 0 ? options.max_error : std::max(range * kDefaultErrorShare, rounding);
  const std::vector<int32_t> ratios(plan.finer, 2);
  auto grid = AdaptiveGrid::create(plan.cells, ratios, Centring::nodes, left);
  if (!grid) return tl::unexpected(grid.error());
  Resampler resampler(mesh, std::move(*survey), plan, limit, std::move(*grid));
  if (auto done = resampler.run(*cells, *faces, *face_bins); !done) {
    return done.error().status == Status::out_of_memory ? too_large(left)
                                                        : tl::unexpected(done.error());
  }
  ResampledMesh resampled{resampler.take(), {}, limit};
  resampled.grid.resolve();
  resampled.level_0.origin = plan.origin;
  resampled.level_0.spacing = plan.spacing;
  return resampled;
}

}  // namespace isosplat
