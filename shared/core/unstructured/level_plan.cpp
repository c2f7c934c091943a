#include "shared/core/unstructured/level_plan.h"

#include <algorithm>
#include <cmath>

#include "shared/core/grid/grid.h"

namespace isosplat {
namespace {

/// Boxes of about this edge, as many as fit evenly. An edge within 0.1 % of an even division is
/// one, so that a mesh of equal boxes has the same boxes as its grid.
Vec3d counts(Vec3d extent, double edge) {
  const auto count = [edge](double length) {
    return std::max(1.0, std::ceil(length / edge - 1e-3));
  };
  return {count(extent.x), count(extent.y), count(extent.z)};
}

Index3 rounded(Vec3d v) {
  return {static_cast<int32_t>(v.x), static_cast<int32_t>(v.y), static_cast<int32_t>(v.z)};
}

Vec3d divided(Vec3d a, Vec3d b) {
  return {a.x / b.x, a.y / b.y, a.z / b.z};
}

double product(Vec3d v) {
  return v.x * v.y * v.z;
}

/// The edge of boxes, doubled until there are at most `most` of them. It is at least a millionth of
/// the longest extent: 0, from a product that underflows, would stay 0.
double coarsened(Vec3d extent, double edge, double most) {
  edge = std::max(edge, std::max({extent.x, extent.y, extent.z}) * 1e-6);
  while (product(counts(extent, edge)) > most) edge *= 2;
  return edge;
}

}  // namespace

Result<MeshSurvey> survey_mesh(const UnstructuredMesh& mesh) {
  MeshSurvey survey;
  survey.sizes.resize(mesh.cells());
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    const float size = mesh.size(cell);
    if (!(size > 0)) continue;
    survey.sizes[cell] = size;
    const bool is_first = survey.cells++ == 0;
    const Box box = box_of(mesh.geometry(cell));
    if (is_first) {
      survey.box = box;
      survey.smallest = survey.largest = size;
      survey.low = survey.high = mesh.values[mesh.corners_of(cell).front()];
    }
    survey.box.add(box.low);
    survey.box.add(box.high);
    survey.smallest = std::min(survey.smallest, size);
    survey.largest = std::max(survey.largest, size);
    for (const uint32_t point : mesh.corners_of(cell)) {
      survey.low = std::min(survey.low, mesh.values[point]);
      survey.high = std::max(survey.high, mesh.values[point]);
    }
  }
  if (survey.cells > 0) return survey;
  return fail(Status::malformed_volume,
              "an unstructured grid: expected cells with values and a volume, found none");
}

LevelPlan plan_levels(const MeshSurvey& survey, double finest, uint64_t voxels) {
  const Vec3d extent = survey.box.high - survey.box.low;
  // Few large cells far apart must not make a large empty grid.
  const double most = std::max(4096.0, 8.0 * static_cast<double>(survey.cells));
  const double edge = coarsened(extent, survey.largest, most);
  const Vec3d n = counts(extent, edge);
  LevelPlan plan{rounded(n), survey.box.low, divided(extent, n), 0};
  const auto fits = [&](double scale) {
    return product(n * scale + Vec3d{1, 1, 1}) <= static_cast<double>(voxels) &&
           std::max({n.x, n.y, n.z}) * scale < kMaxVoxelsPerAxis / 4;
  };
  const double spacing = std::max({plan.spacing.x, plan.spacing.y, plan.spacing.z});
  for (double scale = 1; spacing / scale > survey.smallest * finest * 1.001 && fits(2 * scale);
       scale *= 2) {
    ++plan.finer;
  }
  return plan;
}

BinGrid plan_bins(const MeshSurvey& survey) {
  const Vec3d extent = survey.box.high - survey.box.low;
  const auto cells = static_cast<double>(survey.cells);
  const double edge = coarsened(extent, std::cbrt(product(extent) / cells), 2 * cells + 64);
  const Vec3d n = counts(extent, edge);
  return {rounded(n), survey.box.low, divided(extent, n)};
}

}  // namespace isosplat
