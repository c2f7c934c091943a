#pragma once

#include <optional>
#include <span>

#include "shared/render/pick/ray_hits.h"

namespace isosplat::render {

/// The cap (RenderSettings::clip_caps) on which the ray enters the clipped volume. The nearest hit
/// behind it determines which isovalues are reached there, as in shaders/caps.frag.glsl. `hits`:
/// all hits of the ray, in any order. Returns nothing if there is no cap.
std::optional<SurfacePick> pick_cap(const VolumeGrid& grid, const RenderSettings& settings,
                                    const PickRay& ray, std::span<const PickHit> hits);

}  // namespace isosplat::render
