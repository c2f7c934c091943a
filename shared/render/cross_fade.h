#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <utility>

#include "shared/base/status.h"

namespace isosplat {

/// Two pictures of one size: one that is shown, and one that it gives way to.
class CrossFade {
 public:
  CrossFade() = default;
  ~CrossFade() { release(); }
  CrossFade(const CrossFade&) = delete;
  CrossFade& operator=(const CrossFade&) = delete;

  /// Keeps what `framebuffer` shows. Errors: gl_error.
  Result<void> hold(GLuint framebuffer, int width, int height);
  /// The framebuffer's picture is the one that the held one gives way to. Requires holds().
  void turn_to_picture_in(GLuint framebuffer);
  /// The other picture is shown, and held.
  void arrive() { std::swap(pictures_[0], pictures_[1]); }

  bool holds(int width, int height) const { return holds_ && width == width_ && height == height_; }
  GLuint from() const { return pictures_[0].texture; }  ///< 2D textures
  GLuint to() const { return pictures_[1].texture; }
  uint64_t bytes() const { return uint64_t(width_) * uint64_t(height_) * 8; }

  void release();
  void forget();

 private:
  struct Picture {
    GLuint texture = 0, framebuffer = 0;
  };

  void copy(GLuint framebuffer, const Picture& picture) const;

  bool holds_ = false;
  int width_ = 0, height_ = 0;
  Picture pictures_[2];
};

}  // namespace isosplat
