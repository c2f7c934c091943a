#pragma once

#include <cstdint>
#include <vector>

#include "shared/render/gl/gl_program.h"
#include "shared/render/gl/image_target.h"
#include "shared/render/passes/surface_targets.h"

namespace isosplat::render {

/// The range of depths of each tile (HIDING_TILE_PX) of the surfaces drawn so far. Vertex shaders
/// drop splats outside of it, so that they cost no fragments.
class DepthTiles {
 public:
  /// Allocates the tiles of an image of this size. Errors: gl_error.
  Result<void> prepare(int width, int height);

  /// Computes the tiles from the target's depths. Leaves the target's framebuffer bound, and
  /// changes viewport, program and vertex array.
  void update(const SplatTarget& target, GLuint empty_vertex_array);

  /// Reads the farthest depth of each tile back, row by row from the bottom. Waits for the GPU, and
  /// leaves the tiles' framebuffer bound.
  const std::vector<float>& read_farthest();

  /// RGBA32UI: see shaders/depth_tiles.frag.glsl.
  GLuint texture() const { return tiles_.texture(); }
  uint64_t bytes() const { return tiles_.bytes(); }

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  GlProgram program_;
  std::vector<uint32_t> texels_;  // reused between frames, as the next one
  std::vector<float> farthest_;
  ImageTarget tiles_{GL_RGBA32UI, "for the depths of tiles"};
};

}  // namespace isosplat::render
