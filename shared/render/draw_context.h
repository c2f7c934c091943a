#pragma once

#include <GLES3/gl3.h>

#include "shared/render/frame_statistics.h"
#include "shared/render/gl_limits.h"
#include "shared/render/lighting.h"
#include "shared/render/render_settings.h"
#include "shared/render/shader_programs.h"
#include "shared/render/surface_targets.h"

namespace isosplat::render {

/// What the passes of a frame share. Valid during one call of the renderer.
struct DrawContext {
  const RenderSettings& settings;
  const GlLimits& limits;
  ShaderPrograms& programs;
  SurfaceTargets& targets;
  Lighting& lighting;
  FrameStatistics& statistics;
  int image_height;           ///< of the whole image, of which a tile may be drawn
  GLuint empty_vertex_array;  ///< for passes whose vertex shader only reads gl_VertexID
};

}  // namespace isosplat::render
