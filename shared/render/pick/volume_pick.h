#pragma once

#include <optional>

#include "shared/render/pick/ray_hits.h"
#include "shared/render/samples/chunk_store.h"

namespace isosplat::render {

/// A pick, and its distance along the view in world units, by which those of volumes are compared.
struct VolumePick {
  SurfacePick pick;
  double distance = 0;
};

/// The nearest isosurface or cap of a volume at a place of the image, from its visible chunks.
/// Reads samples back from the GPU.
std::optional<VolumePick> pick_volume(const VolumeGrid& grid, const ValueMapping& mapping,
                                      const ChunkStore& chunks, VolumeId volume,
                                      const RenderSettings& settings, const SceneExtent& scene,
                                      const Camera& camera, const ImagePlace& place);

}  // namespace isosplat::render
