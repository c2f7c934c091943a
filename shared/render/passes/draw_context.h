#pragma once

#include <GLES3/gl3.h>

#include <span>

#include "shared/render/gl/gl_limits.h"
#include "shared/render/passes/frame_statistics.h"
#include "shared/render/passes/lighting.h"
#include "shared/render/passes/shader_programs.h"
#include "shared/render/passes/surface_targets.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// The state that the passes of a frame share. Valid during one call of the renderer.
struct DrawContext {
  const RenderSettings& settings;
  /// The isosurfaces of the settings. Those in the opaque layer have opacity 1.
  std::span<const Isosurface> isosurfaces;
  const GlLimits& limits;
  ShaderPrograms& programs;
  SurfaceTargets& targets;
  Lighting& lighting;
  FrameStatistics& statistics;
  int image_height;           ///< of the whole image, of which a tile may be drawn
  FieldStyle field_style;     ///< of the settings; none if no volume has a field
  GLuint empty_vertex_array;  ///< for passes whose vertex shader only reads gl_VertexID
};

}  // namespace isosplat::render
