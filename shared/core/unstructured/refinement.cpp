#include "shared/core/unstructured/refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/unstructured/border_values.h"
#include "shared/core/unstructured/random_points.h"
#include "shared/core/unstructured/resample.h"

namespace isosplat {
namespace {

/// Edges that are equal but for rounding.
constexpr double kSameEdge = 1.001;
/// Grid cells with larger edges, relative to the cells of the mesh, are divided because of errors.
constexpr double kWrongShare = kFinestShare * 2;
constexpr int32_t kRandomPoints = 16;
constexpr size_t kMostMeshPoints = 64;  ///< that are compared in one grid cell
/// Of the cells of the mesh near a grid cell, as many are prepared for searches. Those near larger
/// grid cells are only listed.
constexpr size_t kMostPrepared = 4096;

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

/// The number of a corner of a grid cell's part among the 3³ nodes of the grid cell.
size_t node_of(int32_t part, int32_t corner) {
  const auto along = [&](int32_t axis) { return (part >> axis & 1) + (corner >> axis & 1); };
  return static_cast<size_t>(along(0) + 3 * along(1) + 9 * along(2));
}

/// The number of a corner of a grid cell among its 3³ nodes.
size_t node_of(int32_t corner) {
  return static_cast<size_t>(2 * (corner & 1) + 6 * (corner >> 1 & 1) + 18 * (corner >> 2));
}

}  // namespace

Refinement::Refinement(const UnstructuredMesh& mesh, const MeshSurvey& survey,
                       const LevelPlan& plan, const std::vector<BoundaryFace>& faces, double limit,
                       uint64_t lists_bytes, AdaptiveGrid grid)
    : mesh_(mesh),
      survey_(survey),
      plan_(plan),
      faces_(faces),
      limit_(limit),
      lists_bytes_(lists_bytes),
      grid_(std::move(grid)),
      near_cells_(mesh),
      near_faces_(mesh) {}

Refinement::GridCell Refinement::grid_cell(uint32_t level, Index3 at) const {
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

Refinement::GridCell Refinement::child(const GridCell& cell, int32_t octant) const {
  return grid_cell(cell.level + 1, cell.at * 2 + Index3{octant & 1, octant >> 1 & 1, octant >> 2});
}

/// Whether a grid cell is larger than a cell of the mesh whose centre lies in it. `box`: of that
/// cell.
bool Refinement::is_larger(const GridCell& cell, uint32_t mesh_cell, const Box& box) const {
  return cell.edge > survey_.sizes[mesh_cell] * kSameEdge &&
         cell.box.contains((box.low + box.high) * 0.5);
}

/// Before something is added to the lists. A vector that grows needs up to three times its size.
Result<void> Refinement::check_lists(uint64_t more_bytes) const {
  if (3 * (lists_.size() * sizeof(uint32_t) + more_bytes) <= lists_bytes_) return {};
  return fail(Status::out_of_memory,
              "an unstructured grid: expected that the cells of the mesh near one grid cell need "
              "at most " +
                  std::to_string(lists_bytes_ >> 20) + " MiB, found more: raise --memory");
}

Result<void> Refinement::run(Index3 cell, std::span<const uint32_t> cells,
                             std::span<const uint32_t> faces) {
  if (cells.empty()) return {};
  lists_.clear();
  if (auto fits = check_lists((cells.size() + faces.size()) * sizeof(uint32_t)); !fits) return fits;
  lists_.insert(lists_.end(), cells.begin(), cells.end());
  lists_.insert(lists_.end(), faces.begin(), faces.end());
  return narrow(grid_cell(0, cell), {{0, cells.size()}, {cells.size(), lists_.size()}});
}

/// Divides grid cells near which there are too many cells of the mesh to prepare them. `near`:
/// numbers of the mesh's cells and of faces_.
Result<void> Refinement::narrow(const GridCell& cell, const Near& near) {
  if (near.cells.size() <= kMostPrepared || is_finest(cell)) return prepare(cell, near);
  const size_t begin = lists_.size();
  if (auto fits = check_lists((near.cells.size() + near.faces.size()) * sizeof(uint32_t)); !fits) {
    return fits;
  }
  Near own;
  bool divides = false;
  for (size_t i = near.cells.begin; i < near.cells.end; ++i) {
    const uint32_t each = lists_[i];
    const Box box = wide_box(mesh_, each);
    if (!box.overlaps(cell.box)) continue;
    divides |= is_larger(cell, each, box);
    lists_.push_back(each);
  }
  own.cells = {begin, lists_.size()};
  const Box wide = gap_box(cell.box);
  const Vec3d margin = (wide.high - wide.low) * kBoxMargin;
  for (size_t i = near.faces.begin; i < near.faces.end; ++i) {
    const uint32_t each = lists_[i];
    const Box box = box_of(mesh_, faces_[each]);
    if (box.overlaps({wide.low - margin, wide.high + margin})) lists_.push_back(each);
  }
  own.faces = {own.cells.end, lists_.size()};
  Result<void> done;
  if (divides && own.cells.size() > kMostPrepared) {
    for (int32_t i = 0; i < 8 && done; ++i) done = narrow(child(cell, i), own);
  } else {
    done = prepare(cell, own);
  }
  lists_.resize(begin);
  return done;
}

/// Prepares cells and faces for searches. `near`: as above.
Result<void> Refinement::prepare(const GridCell& cell, const Near& near) {
  const size_t cells = near.cells.size(), faces = near.faces.size(), begin = lists_.size();
  const uint64_t bytes =
      NearCells::bytes(cells) + NearFaces::bytes(faces) + (cells + faces) * sizeof(uint32_t);
  if (auto fits = check_lists(bytes); !fits) return fits;
  near_cells_.assign(items(near.cells));
  near_faces_.assign(faces_, items(near.faces));
  for (uint32_t i = 0; i < cells; ++i) lists_.push_back(i);
  for (uint32_t i = 0; i < faces; ++i) lists_.push_back(i);
  Corners corners;
  if (cell.level == 0) {
    if (last_ == cell.at - Index3{1, 0, 0}) {
      for (size_t i = 0; i < 8; i += 2) {
        corners.at[i] = last_corners_.at[i + 1];
        corners.are_known[i] = last_corners_.are_known[i + 1];
      }
    }
    last_ = cell.at;
  }
  auto done = visit(cell, {{begin, begin + cells}, {begin + cells, lists_.size()}}, corners);
  if (cell.level == 0) last_corners_ = corners;
  lists_.resize(begin);
  return done;
}

/// `near`: numbers of near_cells_ and near_faces_, here and below.
Result<void> Refinement::visit(const GridCell& cell, const Near& near, Corners& corners) {
  const size_t begin = lists_.size();
  if (auto fits = check_lists((near.cells.size() + near.faces.size()) * sizeof(uint32_t)); !fits) {
    return fits;
  }
  bool divides = false;
  for (size_t i = near.cells.begin; i < near.cells.end; ++i) {
    const uint32_t each = lists_[i];
    const Box& box = near_cells_.box(each);
    if (!box.overlaps(cell.box)) continue;
    divides |= is_larger(cell, near_cells_.cell(each), box);
    lists_.push_back(each);
  }
  if (lists_.size() == begin) return {};
  Near own{{begin, lists_.size()}, {}};
  bool is_crossed = false;
  const Box wide = gap_box(cell.box);
  const Vec3d shrink = (cell.box.high - cell.box.low) * kBoxMargin;
  const Box within{cell.box.low + shrink, cell.box.high - shrink};
  for (size_t i = near.faces.begin; i < near.faces.end; ++i) {
    const uint32_t each = lists_[i];
    if (!near_faces_.crosses(each, wide)) continue;
    is_crossed = is_crossed || near_faces_.crosses(each, within);
    lists_.push_back(each);
  }
  own.faces = {own.cells.end, lists_.size()};
  auto done = divides && !is_finest(cell) ? split(cell, own, corners)
                                          : decide(cell, own, is_crossed, corners);
  lists_.resize(begin);
  return done;
}

Result<void> Refinement::split(const GridCell& cell, const Near& near, Corners& corners) {
  std::array<std::optional<Located>, 27> nodes;
  std::array<bool, 27> are_known{};
  for (int32_t i = 0; i < 8; ++i) {
    nodes[node_of(i)] = corners.at[static_cast<size_t>(i)];
    are_known[node_of(i)] = corners.are_known[static_cast<size_t>(i)];
  }
  for (int32_t part = 0; part < 8; ++part) {
    Corners own;
    for (int32_t i = 0; i < 8; ++i) {
      own.at[static_cast<size_t>(i)] = nodes[node_of(part, i)];
      own.are_known[static_cast<size_t>(i)] = are_known[node_of(part, i)];
    }
    if (auto done = visit(child(cell, part), near, own); !done) return done;
    for (int32_t i = 0; i < 8; ++i) {
      nodes[node_of(part, i)] = own.at[static_cast<size_t>(i)];
      are_known[node_of(part, i)] = own.are_known[static_cast<size_t>(i)];
    }
  }
  for (int32_t i = 0; i < 8; ++i) {
    corners.at[static_cast<size_t>(i)] = nodes[node_of(i)];
    corners.are_known[static_cast<size_t>(i)] = are_known[node_of(i)];
  }
  return {};
}

/// Adds a grid cell as a leaf, divides it, or leaves it empty.
Result<void> Refinement::decide(const GridCell& cell, const Near& near, bool is_crossed,
                                Corners& corners) {
  const auto cells = items(near.cells);
  float size = std::numeric_limits<float>::max();
  size_t found = 0;
  for (size_t i = 0; i < 8; ++i) {
    auto& corner = corners.at[i];
    if (!std::exchange(corners.are_known[i], true)) {
      corner = near_cells_.find(cells, corner_of(cell.box, static_cast<int32_t>(i)));
    }
    if (!corner) continue;
    ++found;
    size = std::min(size, survey_.sizes[corner->cell]);
  }
  // A hole that is as large as the grid cell has all corners, but not the centre, in other cells.
  const bool is_border =
      is_crossed || (found > 0 && found < 8) ||
      (found == 8 && !near_cells_.find(cells, (cell.box.low + cell.box.high) * 0.5));
  if (found == 0 && !is_border) return {};
  if (found == 0) {
    for (const uint32_t each : cells) {
      size = std::min(size, survey_.sizes[near_cells_.cell(each)]);
    }
  }
  const double share = is_border ? kBorderShare : 1;
  if (!is_finest(cell) && cell.edge > size * share * kSameEdge) return split(cell, near, corners);

  std::array<double, 8> values{};
  if (is_border) {
    if (near_faces_.have_gap(items(near.faces), cell.box)) return {};
    std::array<std::optional<double>, 8> known;
    for (size_t i = 0; i < 8; ++i) {
      if (corners.at[i]) known[i] = corners.at[i]->value;
    }
    const auto border = border_values(cell.box, known, [&](Vec3d point) {
      const auto located = near_cells_.find(cells, point);
      return located ? std::optional(located->value) : std::nullopt;
    });
    if (!border) return {};
    values = *border;
  } else {
    for (size_t i = 0; i < 8; ++i) values[i] = corners.at[i]->value;
  }
  if (!is_finest(cell) && is_wrong(cell, cells, values, size, share)) {
    return split(cell, near, corners);
  }
  return add(cell, values);
}

/// Whether a grid cell is to be divided: its edge is larger than a `share` of the mesh's cells at
/// points of the mesh and at random points in it, or its function is wrong there, and its edge is
/// larger than kWrongShare of them. `size`: the smallest one of the cells at its corners.
bool Refinement::is_wrong(const GridCell& cell, std::span<const uint32_t> cells,
                          const std::array<double, 8>& values, float size, double share) const {
  float smallest = size;
  for (const uint32_t each : cells) {
    smallest = std::min(smallest, survey_.sizes[near_cells_.cell(each)]);
  }
  if (!(cell.edge > smallest * kWrongShare * kSameEdge)) return false;
  double most = 0;
  // The more points are known, the larger is the error, and the smaller is the size.
  const auto decides = [&](Vec3d f, double expected, uint32_t mesh_cell) {
    most = std::max(most, std::abs(interpolated(values, f) - expected));
    size = std::min(size, survey_.sizes[mesh_cell]);
    return cell.edge > size * share * kSameEdge ||
           (most > limit_ && cell.edge > size * kWrongShare * kSameEdge);
  };
  size_t points = 0;
  for (const uint32_t each : cells) {
    const uint32_t mesh_cell = near_cells_.cell(each);
    for (const uint32_t point : mesh_.corners_of(mesh_cell)) {
      const Vec3d at = mesh_.points[point];
      if (points >= kMostMeshPoints || !cell.box.contains(at)) continue;
      if (decides(fraction_in(cell.box, at), mesh_.values[point], mesh_cell)) return true;
      ++points;
    }
  }
  const uint64_t seed = (uint64_t{cell.level} << 60) ^ static_cast<uint64_t>(cell.at.x) ^
                        static_cast<uint64_t>(cell.at.y) << 20 ^
                        static_cast<uint64_t>(cell.at.z) << 40;
  RandomPoints random(seed);
  for (int32_t i = 0; i < kRandomPoints; ++i) {
    const Vec3d f = random.in_unit_cube();
    const auto found = near_cells_.find(cells, in_box(cell.box, f));
    if (found && decides(f, found->value, found->cell)) return true;
  }
  return false;
}

Result<void> Refinement::add(const GridCell& cell, const std::array<double, 8>& values) {
  auto added = grid_.add(cell.level, {cell.at, cell.at + Index3{1, 1, 1}}, values);
  if (added || added.error().status != Status::out_of_memory) return added;
  return fail(Status::out_of_memory,
              "an unstructured grid: expected a grid of at most " +
                  std::to_string(grid_.memory_limit() >> 20) +
                  " MiB, found more: raise --memory, or accept a larger --max-error");
}

}  // namespace isosplat
