#pragma once

#include "shared/base/status.h"
#include "shared/render/image_target.h"
#include "shared/render/surface_targets.h"

namespace isosplat {

/// A copy of the depths drawn so far, as a target's own cannot be read while it is drawn into.
/// Squares look up a few places of it to learn whether they are hidden.
class DrawnDepths {
 public:
  /// Makes room for an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height) { return depths_.prepare(width, height); }

  /// Takes the depths of a target of that size, and leaves it bound.
  void copy_from(const SplatTarget& target);

  GLuint texture() const { return depths_.texture(); }  ///< depths, 0 to 1
  uint64_t bytes() const { return depths_.bytes(); }

  void release() { depths_.release(); }
  void abandon() { depths_.abandon(); }

 private:
  ImageTarget depths_{GL_DEPTH_COMPONENT24, "for the drawn depths of an image"};
};

}  // namespace isosplat
