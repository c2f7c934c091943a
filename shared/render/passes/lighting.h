#pragma once

#include <GLES3/gl3.h>

#include <array>
#include <span>
#include <vector>

#include "shared/core/grid/grid.h"
#include "shared/render/gl/gl_program.h"
#include "shared/render/passes/surface_targets.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// Isosurfaces of at least this opacity are drawn as opaque.
inline constexpr float kOpaque = 0.999f;

/// Half the longest diagonal of the clip box of the settings, in world units: the scale of ambient
/// occlusion and shadows. It depends neither on the camera nor on the isovalue.
double visible_radius(const VolumeGrid& grid, const RenderSettings& settings);

/// One of the pictures that Accumulation adds up.
struct StillPicture {
  int index = 0;           ///< 0 … Accumulation::kPictures − 1
  float scene_radius = 1;  ///< visible_radius(), in units of frame space
  float image_height = 1;  ///< units of the visible part of the plane at distance 1 from the eye
  const SurfaceTargets* whole = nullptr;  ///< for a tile: the whole image, in fewer pixels
};

/// The uniforms and the colour map of shaders/light.glsl, eye_dome.glsl and occlusion.glsl.
class Lighting {
 public:
  Lighting() = default;
  ~Lighting() { release(); }
  Lighting(const Lighting&) = delete;
  Lighting& operator=(const Lighting&) = delete;

  /// Sets the uniforms of the current program, with the colours of these isosurfaces: programs for
  /// many surfaces read more than kMaxIsosurfaces of them from a texture. Binds the colour map to
  /// texture unit 3, and that texture to unit 4.
  void apply(const GlProgram& program, const RenderSettings& settings,
             std::span<const Isosurface> isosurfaces);
  /// Sets the uniforms of edge shading.
  static void apply_edges(const GlProgram& program, const RenderSettings& settings,
                          int image_height);
  /// Whether ambient occlusion or shadows are on.
  static bool has_occlusion(const LightSettings& light);
  /// Sets the uniforms of ambient occlusion and shadows.
  static void apply_occlusion(const GlProgram& program, const LightSettings& light,
                              const StillPicture& picture);

  void release();
  /// The context that owned the colour map is gone.
  void abandon();

 private:
  void bind_colour_map(const RenderSettings& settings);
  void bind_colours(std::span<const float> rgba);

  GLuint colour_map_ = 0;
  int loaded_map_ = -1;  // index of the ColourMap in the first row of the texture; −1: none
  std::vector<std::array<uint8_t, 3>> loaded_categories_;  // in the rows after it
  GLuint colours_ = 0;
  std::vector<float> loaded_colours_;  // RGBA of each isosurface in the texture
};

}  // namespace isosplat::render
