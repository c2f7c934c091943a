#include "native/extract/extract_solid.h"

#include <fmt/format.h>

#include "native/extract/chunk_reading.h"
#include "native/extract/extract_mesh.h"
#include "native/extract/field_reading.h"

namespace isosplat {
namespace {

Result<SolidRegion> region_of(const VolumeGrid& grid, uint32_t level, const SolidCuts& cuts) {
  SolidRegion region(grid, level);
  if (cuts.box) {
    const auto& [low, high] = *cuts.box;
    if (auto clipped = region.clip_to_box(low, high); !clipped) {
      return tl::unexpected(clipped.error());
    }
  }
  for (const HalfSpace& plane : cuts.planes) {
    if (auto clipped = region.clip(plane); !clipped) return tl::unexpected(clipped.error());
  }
  return region;
}

}  // namespace

Result<MeshPart> extract_solid(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const SolidCuts& cuts) {
  return catch_out_of_memory(store, [&]() -> Result<MeshPart> {
    const VolumeGrid& grid = grid_of(store, options);
    const auto region = region_of(grid, options.level, cuts);
    if (!region) return tl::unexpected(region.error());
    ExtractOptions of_cells = options;
    of_cells.grid = lattice_grid(grid.voxels);
    of_cells.region = region->cells();
    of_cells.least_distance = SolidRegion::kLeastDistance;
    MeshPart mesh;
    const auto extracted = extract_mesh(store, isovalue, of_cells, [&](const MeshPart& part) {
      append_part(mesh, part);
      return Result<void>{};
    });
    if (!extracted) return tl::unexpected(extracted.error());
    if (const auto closed = region->close(mesh, are_categories(options.fields)); !closed) {
      return fail(closed.error().status,
                  fmt::format("{}: {}", store.path().string(), closed.error().message));
    }
    return mesh;
  });
}

}  // namespace isosplat
