#pragma once

#include <GLES3/gl3.h>

#include "shared/base/status.h"
#include "shared/render/gl_program.h"

namespace isosplat {

/// A coarse depth image (one texel per OCCLUDER_PX² px) of one in OCCLUDER_STRIDE samples, each
/// enlarged to stand for its neighbours: what lies well behind it is likely to be hidden. It errs
/// in both directions, so it only decides what to draw first.
class Occluders {
 public:
  Occluders() = default;
  ~Occluders() { release(); }
  Occluders(const Occluders&) = delete;
  Occluders& operator=(const Occluders&) = delete;

  /// Makes room for an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);
  /// Binds the image, and clears it: nothing hides anything.
  void begin();

  /// Takes the image from what is drawn. Leaves another program and vertex array.
  void take(GLuint empty_vertex_array);

  /// R32UI, bits of the depth (0 to 1).
  GLuint texture() const { return image_; }
  uint64_t bytes() const { return uint64_t(columns_) * uint64_t(rows_) * 8; }

  void release();
  /// The context that owned the objects is gone.
  void forget();

 private:
  GlProgram program_;
  GLuint depths_ = 0, framebuffer_ = 0, image_ = 0, image_framebuffer_ = 0;
  int columns_ = 0, rows_ = 0;
};

}  // namespace isosplat
