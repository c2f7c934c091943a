#pragma once

#include <GLES3/gl3.h>

namespace isosplat {

/// A framebuffer of 8-bit RGBA pixels, to draw into without a window. An OpenGL context must be
/// current as long as it lives.
class OffscreenTarget {
 public:
  /// Leaves the framebuffer bound.
  OffscreenTarget(int width, int height);
  ~OffscreenTarget();
  OffscreenTarget(const OffscreenTarget&) = delete;
  OffscreenTarget& operator=(const OffscreenTarget&) = delete;

  GLuint framebuffer() const { return framebuffer_; }

 private:
  GLuint framebuffer_ = 0, colour_ = 0;
};

}  // namespace isosplat
