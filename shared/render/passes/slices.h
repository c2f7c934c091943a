#pragma once

#include "shared/render/frame/draw_list.h"
#include "shared/render/frame/frame.h"
#include "shared/render/gl/vertex_runs.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/samples/chunk_store.h"
#include "shared/render/samples/sample_texture.h"

namespace isosplat::render {

/// Draws the slices of the settings into the layer of opaque surfaces: a pattern, and over it the
/// resident cells that the plane cuts, finer ones over coarser ones. The README's decision 26
/// describes why.
class Slices {
 public:
  /// `context`: of the layers that are shown, with all surfaces. `frame`: that of these surfaces,
  /// whose uniform block is still bound. Errors: gl_error.
  Result<void> draw(const DrawContext& context, const Frame& frame, const ChunkStore& chunks,
                    const ValueMapping& mapping);

  uint64_t bytes() const { return sample_texture_.bytes(); }
  /// The context that owned the objects is gone.
  void abandon();

 private:
  Result<void> draw_pattern(const DrawContext& context, const Frame& frame, const Plane& plane);
  Result<void> draw_cells(const DrawContext& context, const Frame& frame, const ChunkStore& chunks,
                          const ValueMapping& mapping, const Plane& plane);

  DrawList draw_list_;
  SampleTexture sample_texture_;
  VertexRuns runs_;  // reused between chunks, to avoid allocations
};

}  // namespace isosplat::render
