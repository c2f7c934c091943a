#pragma once

#include <GLES3/gl3.h>

#include "shared/render/gl_program.h"
#include "shared/render/surface_targets.h"

namespace isosplat {

/// The farthest depth of each tile (HIDING_TILE_PX) of what is drawn so far: splats behind it are
/// hidden, and dropped before they cost more than their vertex.
class DepthTiles {
 public:
  DepthTiles() = default;
  ~DepthTiles() { release(); }
  DepthTiles(const DepthTiles&) = delete;
  DepthTiles& operator=(const DepthTiles&) = delete;

  /// Makes room for the tiles of an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);

  /// Takes the depths drawn so far. Leaves the target bound, and another viewport, program and
  /// vertex array.
  void take(const SplatTarget& target, GLuint empty_vertex_array);

  /// R32UI, bits of the depth (0 to 1): they compare as it does.
  GLuint texture() const { return texture_; }

  void release();
  /// The context that owned the objects is gone.
  void forget();

 private:
  GlProgram program_;
  GLuint texture_ = 0, framebuffer_ = 0;
  int columns_ = 0, rows_ = 0;
};

}  // namespace isosplat
