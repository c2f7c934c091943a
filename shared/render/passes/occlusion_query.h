#pragma once

#include <GLES3/gl3.h>

#include <array>
#include <optional>
#include <vector>

#include "shared/core/grid/drawn_chunk.h"
#include "shared/render/gl/gl_program.h"
#include "shared/render/gl/image_target.h"

namespace isosplat::render {

/// Tests on the GPU which regions of chunks are visible in a picture. It either counts the pixels
/// whose surface lies in the boxes of active cells, or tests whether any part of these boxes is in
/// front of the surfaces of the picture, so that finer cells in them might be visible. The CPU
/// reads the result back later, without waiting for the GPU.
class OcclusionQuery {
 public:
  /// A visible chunk. Culled chunks have no samples.
  struct Item {
    ChunkHandle handle = 0;
    std::array<float, 4> block{};  ///< u_block of shaders/block.glsl
    RegionMask regions;
    GLuint vertex_array = 0;
    GLint first = 0;
    GLsizei count = 0;
  };

  /// The layers of the picture to test against.
  struct Picture {
    GLuint depths = 0;           ///< texture array; layer 0 is opaque
    GLuint farthest_depths = 0;  ///< DepthTiles of layer 0
    int layers = 1;
    bool orthographic = false;  ///< Camera::orthographic
    std::vector<float> quantized_isovalues;
    std::vector<GLint> isosurface_layers;  ///< of each quantized isovalue
  };

  OcclusionQuery() = default;
  ~OcclusionQuery() { release(); }
  OcclusionQuery(const OcclusionQuery&) = delete;
  OcclusionQuery& operator=(const OcclusionQuery&) = delete;

  /// Starts a query against a picture, whose uniform block Frame is bound to `frame_binding`.
  /// `min_px`: see Renderer::begin_occlusion_query. Items after the first 1024 are not tested, and
  /// count as visible. Errors: gl_error.
  Result<void> begin(const Picture& picture, const std::vector<Item>& items, int min_px,
                     GLuint frame_binding);

  /// Returns the result of the last query once; nothing until it is available.
  std::optional<std::vector<ChunkVisibility>> take();

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  Result<void> link(bool orthographic, GLuint frame_binding);
  Result<void> prepare_counts(int rows);
  void bind_picture(const Picture& picture) const;
  void draw_items(const std::vector<Item>& items, size_t tested) const;
  void start_reading(int rows);

  GlProgram program_;
  bool orthographic_ = false;                               // of the program
  ImageTarget counts_{GL_RGBA8, "for an occlusion query"};  // a row per item
  GLuint read_buffer_ = 0;
  int min_px_ = 1;
  GLsync fence_ = nullptr;                // of the query in progress
  std::vector<ChunkVisibility> results_;  // of the query in progress, by item
};

}  // namespace isosplat::render
