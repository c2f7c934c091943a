#pragma once

#include <GLES3/gl3.h>

#include <vector>

#include "shared/base/status.h"

namespace isosplat {

/// Where splats are drawn: a framebuffer, and its depth attachment as a layer of a texture array.
struct SplatTarget {
  GLuint framebuffer = 0, depths = 0;
  int layer = 0;
};

/// What surfaces are drawn into before they are lit: layers of surface pixels (RGBA16UI, see
/// surface_pixel.glsl) with depth, the blended kind's sums, and a picture for what is lit as it is
/// drawn. Made for a size, kept until another
/// is asked for.
class SurfaceTargets {
 public:
  SurfaceTargets() = default;
  ~SurfaceTargets() { release(); }
  SurfaceTargets(const SurfaceTargets&) = delete;
  SurfaceTargets& operator=(const SurfaceTargets&) = delete;

  /// Makes at least `layers` layers of this size, and the sums if `blended`; does nothing where
  /// they exist. float_blend: 32-bit sums, else 16-bit. Errors: gl_error.
  Result<void> prepare(int width, int height, int layers, bool blended, bool float_blend);
  /// Makes the picture's target (RGBA8, with the first layer's depths), after prepare(). Errors:
  /// gl_error.
  Result<void> prepare_picture();

  GLuint layer_framebuffer(int layer) const { return framebuffers_[static_cast<size_t>(layer)]; }
  SplatTarget layer(int layer) const { return {layer_framebuffer(layer), depths_, layer}; }
  SplatTarget picture() const { return {picture_framebuffer_, depths_, 0}; }
  SplatTarget sums() const { return {sums_framebuffer_, sums_depth_, 0}; }
  GLuint surfaces() const { return surfaces_; }  ///< texture array
  GLuint depths() const { return depths_; }      ///< texture array
  GLuint picture_colours() const { return picture_; }
  GLuint normal_sums() const { return sums_[0]; }
  GLuint scalar_sums() const { return sums_[1]; }
  int width() const { return width_; }
  int height() const { return height_; }
  uint64_t bytes() const { return bytes_; }

  void release();
  void abandon();

 private:
  int width_ = 0, height_ = 0, layers_ = 0;
  GLuint surfaces_ = 0, depths_ = 0;
  std::vector<GLuint> framebuffers_;
  GLuint picture_ = 0, picture_framebuffer_ = 0;
  GLuint sums_framebuffer_ = 0, sums_[2] = {0, 0}, sums_depth_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace isosplat
