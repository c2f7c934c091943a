#pragma once

#include <GLES3/gl3.h>

#include "shared/core/base/status.h"

namespace isosplat::render {

/// A render target that shaders read afterwards: a texture without mipmaps, as the only attachment
/// of a framebuffer. It is allocated for a size, and kept until prepare() requests another one.
class ImageTarget {
 public:
  /// format: a sized format of colours or depths. purpose: a part of the error message ("to smooth
  /// an image"); must outlive the target.
  ImageTarget(GLenum format, const char* purpose) : format_(format), purpose_(purpose) {}
  ~ImageTarget() { release(); }
  ImageTarget(const ImageTarget&) = delete;
  ImageTarget& operator=(const ImageTarget&) = delete;

  /// Allocates it, with undefined content. Does nothing if it has this size. Leaves the active
  /// texture unit without a 2D texture, and may leave the framebuffer bound. Errors: gl_error.
  Result<void> prepare(int width, int height);

  GLuint framebuffer() const { return framebuffer_; }
  GLuint texture() const { return texture_; }  ///< 2D, read without interpolation
  int width() const { return width_; }
  int height() const { return height_; }
  bool has_size(int width, int height) const { return width == width_ && height == height_; }
  uint64_t bytes() const;

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  GLenum format_;
  const char* purpose_;
  GLuint texture_ = 0, framebuffer_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace isosplat::render
