#pragma once

#include <array>
#include <cstdint>

#include "shared/core/grid/grid.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// u_scalar of shaders/splat.glsl: the weights of 1, of the gradient's length, and of the
/// projection error. The weighted sum is the scalar of surface pixels: mostly the position in the
/// colour map. frame_unit: Frame::unit().
std::array<float, 3> scalar_weights(const RenderSettings& settings, const ValueMapping& mapping,
                                    double frame_unit, double isovalue, uint32_t level);

/// u_field of shaders/field.glsl, of a field with this mapping.
std::array<float, 3> field_weights(const RenderSettings& settings, const ValueMapping& field);

/// u_field_missing of shaders/field_corners.glsl.
float least_missing(const ValueMapping& field);

}  // namespace isosplat::render
