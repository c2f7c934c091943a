#pragma once

#include "shared/core/base/status.h"
#include "shared/render/gl/image_target.h"
#include "shared/render/passes/surface_targets.h"

namespace isosplat::render {

/// A copy of the depths drawn so far, since shaders cannot read the depths of the target that they
/// draw into. Vertex shaders of quads read it at a few points to find whether they are occluded.
class DrawnDepths {
 public:
  /// Allocates an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height) { return depths_.prepare(width, height); }

  /// Copies the depths of a target of this size, and leaves its framebuffer bound.
  void copy_from(const SplatTarget& target);

  GLuint texture() const { return depths_.texture(); }  ///< depths, 0 to 1
  uint64_t bytes() const { return depths_.bytes(); }

  void release() { depths_.release(); }
  void abandon() { depths_.abandon(); }

 private:
  ImageTarget depths_{GL_DEPTH_COMPONENT24, "for the drawn depths of an image"};
};

}  // namespace isosplat::render
