#pragma once

#include <string>

namespace isosplat::render {

/// Limits of the GL implementation.
struct RendererLimits {
  float max_point_size = 1;  ///< larger splats are drawn as two triangles
  int max_texture_size = 0;
  bool float_targets = false;  ///< EXT_color_buffer_float: smooth shading, and refine()
  bool float_blend = false;    ///< EXT_float_blend: 32-bit sums of gradients, else 16
  std::string renderer;        ///< GL_RENDERER
};

/// Limits and extensions of the current GL context.
struct GlLimits {
  RendererLimits offered;
  /// Width of the guard band: the viewport is this much larger than the image on each side. GL
  /// discards points whose centres lie outside of the viewport, regardless of their size.
  float guard_px = 0;
  bool parallel_compile = false;  ///< KHR_parallel_shader_compile
  bool multi_draw = false;        ///< WEBGL_multi_draw
  bool on_cpu = false;            ///< llvmpipe, whose threads start to rasterise at a flush
};

/// Queries the current context. Points are limited to `max_point_size` px, even where GL allows
/// larger ones.
GlLimits query_gl_limits(float max_point_size);

}  // namespace isosplat::render
