#pragma once

#include <optional>

#include "shared/render/pick/ray_hits.h"
#include "shared/render/samples/chunk_store.h"

namespace isosplat::render {

/// The nearest position on the ray, before the distance `before`, at which a slice shows a value.
/// The value is that of the finest resident cell there, visible or not. Where a slice shows no
/// value, the surfaces behind it are visible. Reads samples back from the GPU.
std::optional<SurfacePick> pick_slice(const VolumeGrid& grid, const ValueMapping& mapping,
                                      const RenderSettings& settings, const ChunkStore& chunks,
                                      const PickRay& ray, double before);

}  // namespace isosplat::render
