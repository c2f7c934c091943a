#pragma once

#include "shared/base/status.h"
#include "shared/render/image_target.h"

namespace isosplat {

/// Two pictures of one size: one that is shown, and one that it gives way to.
class CrossFade {
 public:
  /// Keeps what `framebuffer` shows. Errors: gl_error.
  Result<void> hold(GLuint framebuffer, int width, int height);
  /// The framebuffer's picture is the one that the held one gives way to. Requires holds().
  void turn_to_picture_in(GLuint framebuffer);
  /// The other picture is shown, and held.
  void arrive() { shown_ = 1 - shown_; }

  bool holds(int width, int height) const { return holds_ && from().has_size(width, height); }
  const ImageTarget& from() const { return pictures_[shown_]; }
  const ImageTarget& to() const { return pictures_[1 - shown_]; }
  uint64_t bytes() const { return from().bytes() + to().bytes(); }

  void release();
  void abandon();

 private:
  void copy(GLuint framebuffer, const ImageTarget& picture) const;

  ImageTarget pictures_[2] = {{GL_RGBA8, "to keep a picture"}, {GL_RGBA8, "to keep a picture"}};
  int shown_ = 0;
  bool holds_ = false;
};

}  // namespace isosplat
