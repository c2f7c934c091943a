#include "shared/core/unstructured/resample.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/core/unstructured/boundary_faces.h"
#include "shared/core/unstructured/layer_bins.h"
#include "shared/core/unstructured/level_plan.h"
#include "shared/core/unstructured/refinement.h"

namespace isosplat {
namespace {

/// Values that are equal but for rounding, as a share of the largest one.
constexpr double kRounding = 1e-12;
/// Shares of the memory: for lists of cells and faces near one grid cell of level 0, and at most
/// for those of several layers of such cells.
constexpr uint64_t kListsShare = 8, kLayersShare = 4;

/// The cells and faces of a mesh near the grid cells of level 0.
struct Layers {
  LayerBins cells, faces;

  uint64_t bytes(int32_t layer) const {
    return cells.layer_bytes(layer) + faces.layer_bytes(layer);
  }
};

/// The memory for the lists of layers: as many as fit into their share, but at least one.
Result<uint64_t> layers_memory(const Layers& layers, int32_t count, uint64_t memory_bytes) {
  uint64_t all = 0, most = 0;
  for (int32_t z = 0; z < count; ++z) {
    all += layers.bytes(z);
    most = std::max(most, layers.bytes(z));
  }
  if (most <= memory_bytes / 2) return std::min(all, std::max(most, memory_bytes / kLayersShare));
  return fail(Status::out_of_memory,
              "an unstructured grid: expected lists of the cells near one layer of the grid of at "
              "most " +
                  std::to_string(memory_bytes >> 21) + " MiB, found more: raise --memory");
}

Result<void> refine(Refinement& refinement, Layers& layers, const LevelPlan& plan,
                    uint64_t layers_bytes) {
  const Index3 n = plan.cells;
  for (int32_t first = 0, last = 0; first < n.z; first = last) {
    uint64_t bytes = 0;
    for (; last < n.z && bytes + layers.bytes(last) <= layers_bytes; ++last) {
      bytes += layers.bytes(last);
    }
    layers.cells.fill(first, last);
    layers.faces.fill(first, last);
    for (int32_t z = first; z < last; ++z) {
      for (int32_t y = 0; y < n.y; ++y) {
        for (int32_t x = 0; x < n.x; ++x) {
          const Index3 at{x, y, z};
          auto done = refinement.run(at, layers.cells.items(at), layers.faces.items(at));
          if (!done) return done;
        }
      }
    }
  }
  return {};
}

}  // namespace

Result<ResampledMesh> resample(const UnstructuredMesh& mesh, const ResampleOptions& options) {
  const auto survey = survey_mesh(mesh);
  if (!survey) return tl::unexpected(survey.error());
  uint64_t left = options.memory_bytes;
  const auto take = [&](uint64_t bytes) { left -= std::min(left, bytes); };
  take(mesh.cells() * sizeof(float));
  const auto faces = boundary_faces(mesh, *survey, left);
  if (!faces) return tl::unexpected(faces.error());
  take(faces->capacity() * sizeof(BoundaryFace));

  const LevelPlan plan = plan_levels(*survey, kFinestShare, kMostLatticeVoxels);
  const auto cell_box = [&](size_t cell) -> std::optional<Box> {
    if (!(survey->sizes[cell] > 0)) return std::nullopt;
    return wide_box(mesh, cell);
  };
  const auto face_box = [&](size_t face) -> std::optional<Box> {
    return box_of(mesh, (*faces)[face]);
  };
  Layers layers{{plan, mesh.cells(), cell_box, 0}, {plan, faces->size(), face_box, kGapMargin}};
  const auto layers_bytes = layers_memory(layers, plan.cells.z, left);
  if (!layers_bytes) return tl::unexpected(layers_bytes.error());
  const uint64_t lists_bytes = left / kListsShare;
  take(*layers_bytes + lists_bytes);

  const double range = survey->high - survey->low;
  // A constant field would otherwise be refined because of rounding.
  const double rounding = kRounding * std::max(std::abs(survey->low), std::abs(survey->high));
  const double limit =
      options.max_error > 0 ? options.max_error : std::max(range * kDefaultErrorShare, rounding);
  const std::vector<int32_t> ratios(plan.finer, 2);
  auto grid = AdaptiveGrid::create(plan.cells, ratios, Centring::nodes, left);
  if (!grid) return tl::unexpected(grid.error());
  Refinement refinement(mesh, *survey, plan, *faces, limit, lists_bytes, std::move(*grid));
  if (auto done = refine(refinement, layers, plan, *layers_bytes); !done) {
    return tl::unexpected(done.error());
  }
  ResampledMesh resampled{refinement.take(), {}, limit};
  resampled.grid.resolve();
  resampled.level_0.origin = plan.origin;
  resampled.level_0.spacing = plan.spacing;
  return resampled;
}

}  // namespace isosplat
