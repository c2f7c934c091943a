#pragma once

#include <GLES3/gl3.h>

#include <array>
#include <optional>
#include <vector>

#include "shared/grid/drawn_chunk.h"
#include "shared/render/gl_program.h"
#include "shared/render/image_target.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// Finds out on the GPU which regions of chunks a picture shows: how many of its pixels lie in the
/// boxes of their active cells, or whether any part of these boxes is in front of what it shows, so
/// that what finer cells have there might be seen. The answer comes back later, so that nobody
/// waits.
class OcclusionQuery {
 public:
  /// A visible chunk; without samples where it was culled.
  struct Item {
    ChunkHandle handle = 0;
    std::array<float, 4> block{};  ///< u_block of splat.vert.glsl
    RegionMask regions;
    GLuint vertex_array = 0;
    GLint first = 0;
    GLsizei count = 0;
  };

  /// What is tested: a picture's layers as they were drawn.
  struct Picture {
    GLuint depths = 0;           ///< texture array; layer 0 is opaque
    GLuint farthest_depths = 0;  ///< DepthTiles of layer 0
    int layers = 1;
    std::vector<float> quantized_isovalues;
    std::vector<GLint> isosurface_layers;  ///< of each quantized isovalue
  };

  OcclusionQuery() = default;
  ~OcclusionQuery() { release(); }
  OcclusionQuery(const OcclusionQuery&) = delete;
  OcclusionQuery& operator=(const OcclusionQuery&) = delete;

  /// Tests the picture, seen as the uniform block at `frame_binding` says. `min_px`: see
  /// Renderer::begin_occlusion_query. Beyond the first 1024, items count as seen. Errors: gl_error.
  Result<void> begin(const Picture& picture, const std::vector<Item>& items, int min_px,
                     GLuint frame_binding);

  /// The answer to the last query, once; nothing before it is there.
  std::optional<std::vector<ChunkVisibility>> take();

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  Result<void> link(GLuint frame_binding);
  Result<void> make_answer(int rows);

  GlProgram program_;
  ImageTarget answer_{GL_RGBA8, "for an occlusion query"};
  GLuint read_buffer_ = 0;
  int min_px_ = 1;
  GLsync done_ = nullptr;
  std::vector<ChunkVisibility> asked_;
};

}  // namespace isosplat
