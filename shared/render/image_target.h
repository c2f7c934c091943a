#pragma once

#include <GLES3/gl3.h>

#include "shared/base/status.h"

namespace isosplat {

/// An image that is drawn into, and read by shaders afterwards: a texture without further levels,
/// and the framebuffer whose only attachment it is. Made for a size, kept until another is asked
/// for.
class ImageTarget {
 public:
  /// format: sized, of colours or depths. purpose: what it is for, where there is no room ("to
  /// smooth an image"); outlives the target.
  ImageTarget(GLenum format, const char* purpose) : format_(format), purpose_(purpose) {}
  ~ImageTarget() { release(); }
  ImageTarget(const ImageTarget&) = delete;
  ImageTarget& operator=(const ImageTarget&) = delete;

  /// Makes it, with undefined content; does nothing where it has that size. Leaves the active
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

}  // namespace isosplat
