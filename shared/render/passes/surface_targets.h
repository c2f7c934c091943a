#pragma once

#include <GLES3/gl3.h>

#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::render {

/// A framebuffer for splats, and its depth attachment: a layer of a texture array.
struct SplatTarget {
  GLuint framebuffer = 0, depths = 0;
  int layer = 0;
};

/// The render targets of surfaces: layers of surface pixels (RGBA16UI, see surface_pixel.glsl) with
/// depth, and a picture for surfaces that are lit while they are drawn.
/// They are allocated for a size, and kept until prepare() requests another one.
class SurfaceTargets {
 public:
  SurfaceTargets() = default;
  ~SurfaceTargets() { release(); }
  SurfaceTargets(const SurfaceTargets&) = delete;
  SurfaceTargets& operator=(const SurfaceTargets&) = delete;

  /// Allocates at least `layers` layers of this size, unless they exist. Errors: gl_error.
  Result<void> prepare(int width, int height, int layers);
  /// Allocates the picture (RGBA8, with the depths of the first layer). Requires prepare(). Errors:
  /// gl_error.
  Result<void> prepare_picture();

  GLuint layer_framebuffer(int layer) const { return framebuffers_[static_cast<size_t>(layer)]; }
  SplatTarget layer(int layer) const { return {layer_framebuffer(layer), depths_, layer}; }
  SplatTarget picture() const { return {picture_framebuffer_, depths_, 0}; }
  GLuint surfaces() const { return surfaces_; }  ///< texture array
  GLuint depths() const { return depths_; }      ///< texture array
  GLuint picture_colours() const { return picture_; }
  int width() const { return width_; }
  int height() const { return height_; }
  uint64_t bytes() const { return bytes_; }

  void swap(SurfaceTargets& other);
  void release();
  void abandon();

 private:
  Result<void> create_layers();

  int width_ = 0, height_ = 0, layers_ = 0;
  GLuint surfaces_ = 0, depths_ = 0;
  std::vector<GLuint> framebuffers_;
  GLuint picture_ = 0, picture_framebuffer_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace isosplat::render
