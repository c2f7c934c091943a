#pragma once

#include <span>
#include <vector>

#include "shared/render/frame/draw_list.h"
#include "shared/render/gl/image_target.h"
#include "shared/render/gl/vertex_runs.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/lattice_regions.h"
#include "shared/render/passes/smooth_normals.h"
#include "shared/render/samples/sample_texture.h"

namespace isosplat::render {

/// Smooth normals from gradients at lattice points (README.md, decision 29). The gradients are
/// computed once for each region of a surface, and kept while the chunks around it stay the same.
class GradientLattice {
 public:
  /// A volume in a frame. The uniform block of the frame is bound.
  struct Source {
    const Frame& frame;
    DrawList& list;  ///< collected for the frame
    const ChunkStore& chunks;
    const ValueMapping& mapping;
  };

  /// Whether all chunks in view whose cells have smooth normals are of the finest level in view.
  /// Gradients at lattice points need this.
  static bool has_one_level(const DrawList& list, SmoothSizes sizes);

  /// Replaces the normals of the layer's pixels that show these isosurfaces. Changes the
  /// visibilities of the list. Returns the isosurfaces that keep their normals: all without
  /// has_one_level(), and those whose gradients do not fit into 32 MiB with the others.
  /// Errors: gl_error.
  Result<std::vector<int>> replace_normals(const DrawContext& context, const Source& source,
                                           std::span<const int> isosurfaces, int layer,
                                           SmoothSizes sizes, SampleTexture& samples);

  /// Whether triangles have smooth normals: some are in view, and there are float targets.
  static bool has_triangles(const DrawContext& context, const DrawList& list);

  /// Computes the gradients around an isosurface's triangles, and binds them to units 5 and 6.
  /// Changes the visibilities of the list. Returns false without has_triangles(), or if they do not
  /// fit into 32 MiB with the others. Errors: gl_error.
  Result<bool> prepare_triangles(const DrawContext& context, const Source& source, int isosurface,
                                 SampleTexture& samples);
  /// Sets u_first_region, for a chunk.
  void set_block(const GlProgram& program, int isosurface, const BlockKey& block) const;

  uint64_t bytes() const;

  GradientLattice() = default;
  ~GradientLattice();
  GradientLattice(const GradientLattice&) = delete;
  GradientLattice& operator=(const GradientLattice&) = delete;
  /// The context that owned the objects is gone.
  void abandon();

 private:
  Result<bool> update(const DrawContext& context, const Source& source, int isosurface,
                      SmoothSizes sizes, SampleTexture& samples);
  bool assign_pages(const DrawContext& context, LatticeRegions& regions);
  Result<void> set_capacity(uint32_t pages);
  void clear_pages(std::span<const uint32_t> pages) const;
  void upload_table(const LatticeRegions& regions);
  Result<void> fill_pages(const DrawContext& context, const Source& source,
                          float quantized_isovalue, const LatticeRegions& regions,
                          SampleTexture& samples);
  Result<void> clear_normals(const DrawContext& context);
  Result<void> add_normals(const DrawContext& context, const Source& source, int isosurface,
                           int layer, SmoothSizes sizes);
  Result<void> copy_normals(const DrawContext& context, int layer);

  ImageTarget gradients_{GL_RGBA16F, "for the gradients of smooth normals"};
  ImageTarget normals_{GL_RG16UI, "for smooth normals"};
  std::vector<LatticeRegions> surfaces_;  // by isosurface
  FreePages free_;
  uint32_t capacity_ = 0;       // pages of the texture, with page 0
  bool has_no_memory_ = false;  // for a larger texture
  GLuint table_ = 0;            // the table of the isosurface that was updated last
  Index3 table_size_{0, 0, 0};
  std::vector<uint32_t> uploaded_;
  VertexRuns runs_;  // reused between chunks, to avoid allocations
};

}  // namespace isosplat::render
