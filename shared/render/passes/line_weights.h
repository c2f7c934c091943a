#pragma once

#include <array>

#include "shared/core/grid/grid.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// The uniforms of shaders/field_lines.glsl. There are no lines if a quantized value has more than
/// 16 or less than 1e-15, or a decade more than 10,000 or less than 1e-15
/// (hasLines in web/viewer/field_lines.ts).
struct LineWeights {
  std::array<float, 4> lines;  ///< u_lines
  std::array<float, 3> tones;  ///< u_line_tones
};
LineWeights line_weights(const RenderSettings& settings, const ValueMapping& field);

}  // namespace isosplat::render
