#pragma once

#include "shared/render/gl_program.h"
#include "shared/render/image_target.h"
#include "shared/render/surface_targets.h"

namespace isosplat {

/// The farthest depth of each tile (HIDING_TILE_PX) of what is drawn so far: splats behind it are
/// hidden, and dropped before they cost more than their vertex.
class DepthTiles {
 public:
  /// Makes room for the tiles of an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);

  /// Takes the depths drawn so far. Leaves the target bound, and another viewport, program and
  /// vertex array.
  void update(const SplatTarget& target, GLuint empty_vertex_array);

  /// R32UI, bits of the depth (0 to 1): they compare as it does.
  GLuint texture() const { return tiles_.texture(); }
  uint64_t bytes() const { return tiles_.bytes(); }

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  GlProgram program_;
  ImageTarget tiles_{GL_R32UI, "for the depths of tiles"};
};

}  // namespace isosplat
