#pragma once

#include <array>
#include <optional>
#include <vector>

#include "native/extract/extract.h"
#include "shared/core/mesh/mesh_part.h"
#include "shared/core/mesh/solid_region.h"

namespace isosplat {

/// The part of a solid that is extracted, in the world.
struct SolidCuts {
  std::optional<std::array<Vec3d, 2>> box = {};  ///< low and high corner
  std::vector<HalfSpace> planes = {};
};

/// The surface of the solid with values above the isovalue: the isosurface, closed where the volume
/// ends and where it is cut. Each edge has two triangles, in opposite directions. `options.region`
/// is not used. The whole mesh is in memory: some 150 bytes for each vertex. Errors: those of
/// extract_mesh and SolidRegion, among them invalid_argument if missing voxels leave holes.
Result<MeshPart> extract_solid(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const SolidCuts& cuts);

}  // namespace isosplat
