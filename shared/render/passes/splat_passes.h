#pragma once

#include <span>

#include "shared/render/frame/draw_list.h"
#include "shared/render/gl/vertex_runs.h"
#include "shared/render/passes/depth_tiles.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/drawn_depths.h"
#include "shared/render/passes/smooth_normals.h"
#include "shared/render/samples/sample_texture.h"

namespace isosplat::render {

/// What the splats of a frame are drawn from, and how.
struct SplatFrame {
  const Frame& frame;
  const SampleBuffers& buffers;
  const ValueMapping& mapping;
  SplatKind kind;
  bool lit;  ///< draws into the lit picture instead of a layer
};

/// Draws the splats of chunks into a layer of surface pixels, or into the lit picture.
class SplatPasses {
 public:
  /// Collects the chunks that the passes draw. margin_cells: see DrawList::collect(). Returns the
  /// number of culled chunks.
  uint32_t collect(const ChunkStore& chunks, const Frame& frame, double margin_cells) {
    return draw_list_.collect(chunks, frame, margin_cells);
  }

  /// Draws one isosurface of the settings. Adds to samples_drawn, chunks_drawn and draw_calls of
  /// the statistics. Errors: gl_error.
  Result<void> draw_isosurface(const DrawContext& context, const SplatFrame& splats, int isosurface,
                               int layer);

  /// Replaces the normals of a layer by smooth ones, after all its isosurfaces (indices into those
  /// of the settings) are drawn; cells that have smooth normals already keep them. Requires float
  /// targets. Adds to draw_calls. Errors: gl_error.
  Result<void> smooth_normals(const DrawContext& context, const SplatFrame& splats,
                              std::span<const int> isosurfaces, int layer, SmoothSizes sizes);

  /// Starts to compile the programs of smooth_normals() for the chunks that were collected last.
  void start_smooth_normals(ShaderPrograms& programs, float max_point_size) const;

  /// Draws, into the bound framebuffer, the cells of an isosurface at the clip planes, for caps
  /// (shaders/cut_cells.frag.glsl). `reachable`: the quantized isovalues that are shown, each once,
  /// ascending; that of the isosurface is the one of this rank, from 1. `margin_px`: px around them
  /// that are covered as well. Errors: gl_error.
  Result<void> draw_cut_cells(const DrawContext& context, const SplatFrame& splats, int isosurface,
                              std::span<const float> reachable, int rank, float margin_px);

  /// Uses the programs of most first pictures on an inactive sample, so that the driver completes
  /// work that it defers to the first draw call. Errors: gl_error.
  Result<void> warm_up(const DrawContext& context, const SampleBuffers& buffers,
                       const SampleRange& inactive_sample);

  /// Computes the farthest depth of each tile of layer 0. Returns the texture of DepthTiles.
  /// Errors: gl_error.
  Result<GLuint> farthest_depths(const DrawContext& context);

  /// A chunk of the last frame, or null if it was culled.
  const DrawItem* find(ChunkHandle handle) const { return draw_list_.find(handle); }

  uint64_t bytes() const;

  /// The context that owned the objects is gone.
  void abandon();

 private:
  struct Pass;
  struct BoundState;

  Result<void> draw_with_occlusion_culling(const Pass& pass, const SplatTarget& target);
  Result<void> draw_subset(const Pass& pass, ClusterSubset subset);
  Result<void> draw_item(const Pass& pass, ClusterSubset subset, const DrawItem& item,
                         BoundState& bound);
  static void set_support(const Pass& pass, const BoundState& bound);
  Result<void> draw_gradients(const DrawContext& context, const SplatFrame& splats,
                              std::span<const int> isosurfaces, SmoothSizes sizes);
  void use_program(const Pass& pass, SplatPass variant, bool pulled, bool drops_hidden,
                   const ShaderPrograms::Splat& program);

  DrawList draw_list_;
  DrawnDepths drawn_depths_;
  DepthTiles depth_tiles_;
  SampleTexture sample_texture_;
  SmoothNormals smooth_normals_;
  VertexRuns runs_;  // reused between chunks, to avoid allocations
};

}  // namespace isosplat::render
