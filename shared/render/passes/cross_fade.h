#pragma once

#include "shared/core/base/status.h"
#include "shared/render/gl/image_target.h"

namespace isosplat::render {

/// Two pictures of one size, for a cross-fade from the one to the other.
class CrossFade {
 public:
  /// Copies the picture in `framebuffer`, to fade from it. Errors: gl_error.
  Result<void> set_from(GLuint framebuffer, int width, int height);
  /// Copies the picture in `framebuffer`, to fade to it. Requires has_from().
  void set_to(GLuint framebuffer);
  /// Ends the fade: the next one starts from the picture that this one led to.
  void finish() { from_ = 1 - from_; }

  /// Whether there is a picture of this size to fade from.
  bool has_from(int width, int height) const { return has_from_ && from().has_size(width, height); }
  const ImageTarget& from() const { return pictures_[from_]; }
  const ImageTarget& to() const { return pictures_[1 - from_]; }
  uint64_t bytes() const { return from().bytes() + to().bytes(); }

  void release();
  void abandon();

 private:
  void copy(GLuint framebuffer, const ImageTarget& picture) const;

  ImageTarget pictures_[2] = {{GL_RGBA8, "to keep a picture"}, {GL_RGBA8, "to keep a picture"}};
  int from_ = 0;  // index of from()
  bool has_from_ = false;
};

}  // namespace isosplat::render
