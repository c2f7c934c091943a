#pragma once

#include <GLES3/gl3.h>

#include "shared/base/status.h"
#include "shared/render/surface_targets.h"

namespace isosplat {

/// A copy of the depths drawn so far, as a target's own cannot be read while it is drawn into.
/// Squares look up a few places of it to learn whether they are hidden.
class DrawnDepths {
 public:
  DrawnDepths() = default;
  ~DrawnDepths() { release(); }
  DrawnDepths(const DrawnDepths&) = delete;
  DrawnDepths& operator=(const DrawnDepths&) = delete;

  /// Makes room for an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);

  /// Takes the depths of a target of that size, and leaves it bound.
  void take(const SplatTarget& target);

  GLuint texture() const { return texture_; }  ///< depths, 0 to 1
  uint64_t bytes() const { return uint64_t(width_) * uint64_t(height_) * 4; }

  void release();
  /// The context that owned the objects is gone.
  void forget();

 private:
  GLuint texture_ = 0, framebuffer_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace isosplat
