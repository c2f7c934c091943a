#pragma once

#include <array>
#include <span>

#include "shared/render/frame/draw_list.h"
#include "shared/render/gl/vertex_runs.h"
#include "shared/render/passes/depth_tiles.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/drawn_depths.h"
#include "shared/render/passes/gradient_lattice.h"
#include "shared/render/passes/smooth_normals.h"
#include "shared/render/passes/triangle_cases.h"
#include "shared/render/samples/sample_texture.h"

namespace isosplat::render {

/// The data and the settings with which the splats of a volume are drawn in a frame. The uniform
/// block of the frame is bound.
struct SplatFrame {
  const Frame& frame;
  DrawList& list;  ///< collected for the frame
  const ChunkStore& chunks;
  const ValueMapping& mapping;
  std::span<const int> isosurfaces;  ///< of the volume, indices into those of the settings
  SplatKind kind;
  bool lit;                             ///< draws into the lit picture instead of a layer
  const ValueMapping* field = nullptr;  ///< that colours show; null: none
};

/// Draws the splats of chunks into a layer of surface pixels, or into the lit picture.
class SplatPasses {
 public:
  /// Draws one isosurface of the settings. Adds to samples_drawn, chunks_drawn and draw_calls of
  /// the statistics. Errors: gl_error.
  Result<void> draw_isosurface(const DrawContext& context, const SplatFrame& splats, int isosurface,
                               int layer);

  /// Replaces the normals of a layer by smooth ones, where it shows these isosurfaces of the
  /// volume, after all surfaces of the layer are drawn; cells that have smooth normals already keep
  /// them. Requires float targets. Adds to draw_calls. Errors: gl_error.
  Result<void> smooth_normals(const DrawContext& context, const SplatFrame& splats,
                              std::span<const int> isosurfaces, int layer, SmoothSizes sizes);

  /// Draws, into the bound framebuffer, the cells of an isosurface at the clip planes, for caps
  /// (shaders/cut_cells.frag.glsl). `reachable`: the quantized isovalues that are shown, each once,
  /// ascending. `rank`: the position of the isosurface's isovalue in `reachable`, from 1.
  /// `margin_px`: px around the cells that are covered as well. Errors: gl_error.
  Result<void> draw_cut_cells(const DrawContext& context, const SplatFrame& splats, int isosurface,
                              std::span<const float> reachable, int rank, float margin_px);

  /// Uses the programs of most first pictures on an inactive sample, so that the driver completes
  /// work that it defers to the first draw call. Errors: gl_error.
  Result<void> warm_up(const DrawContext& context, const SampleBuffers& buffers,
                       const SampleRange& inactive_sample);

  /// Computes the farthest depth of each tile of layer 0. Returns the texture of DepthTiles.
  /// Errors: gl_error.
  Result<GLuint> farthest_depths(const DrawContext& context);

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
  Result<void> sum_in_image(const DrawContext& context, const SplatFrame& splats,
                            std::span<const int> isosurfaces, int layer, SmoothSizes sizes);
  Result<void> draw_gradients(const DrawContext& context, const SplatFrame& splats,
                              std::span<const int> isosurfaces, SmoothSizes sizes);
  void use_program(const Pass& pass, SplatPass variant, bool pulled, bool drops_hidden,
                   const ShaderPrograms::Splat& program);

  DrawnDepths drawn_depths_;
  DepthTiles depth_tiles_;
  SampleTexture sample_texture_, field_texture_;
  TriangleCases triangle_cases_;
  SmoothNormals smooth_normals_;
  GradientLattice gradient_lattice_;
  VertexRuns runs_;  // reused between chunks, to avoid allocations
};

}  // namespace isosplat::render
