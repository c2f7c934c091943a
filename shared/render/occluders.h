#pragma once

#include "shared/base/status.h"
#include "shared/render/gl_program.h"
#include "shared/render/image_target.h"

namespace isosplat {

/// A coarse depth image (one texel per OCCLUDER_PX² px) of one in OCCLUDER_STRIDE samples, each
/// enlarged to stand for its neighbours: what lies well behind it is likely to be hidden. It errs
/// in both directions, so it only decides what to draw first.
class Occluders {
 public:
  /// Makes room for an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);
  /// Binds the image, and clears it: nothing hides anything.
  void begin();

  /// Takes the image from what is drawn. Leaves another program and vertex array.
  void take(GLuint empty_vertex_array);

  /// R32UI, bits of the depth (0 to 1).
  GLuint texture() const { return image_.texture(); }
  uint64_t bytes() const { return depths_.bytes() + image_.bytes(); }

  void release();
  /// The context that owned the objects is gone.
  void forget();

 private:
  GlProgram program_;
  ImageTarget depths_{GL_DEPTH_COMPONENT24, "for occluders"};  // as they are drawn
  ImageTarget image_{GL_R32UI, "for occluders"};
};

}  // namespace isosplat
