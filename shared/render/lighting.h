#pragma once

#include <GLES3/gl3.h>

#include "shared/render/gl_program.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// Isosurfaces of at least this opacity are drawn as opaque.
inline constexpr float kOpaque = 0.999f;

/// sRGB to linear colours by a gamma of 2, as shaders/gamma.glsl; clamps to 0 … 1.
Vec3f to_linear(Vec3f colour);

/// The uniforms and the colour map of shaders/light.glsl.
class Lighting {
 public:
  Lighting() = default;
  ~Lighting() { release(); }
  Lighting(const Lighting&) = delete;
  Lighting& operator=(const Lighting&) = delete;

  /// Sets the uniforms of the current program. Binds the colour map to texture unit 3, and leaves
  /// that unit active.
  void apply(const GlProgram& program, const RenderSettings& settings, int image_height);

  void release();
  /// The context that owned the colour map is gone.
  void abandon();

 private:
  void bind_colour_map(ColourMap map);

  GLuint colour_map_ = 0;
  int loaded_map_ = -1;  // index of the ColourMap in the texture; −1: none
};

}  // namespace isosplat
