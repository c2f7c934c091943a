#pragma once

#include <span>

#include "shared/render/gl/image_target.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/splat_passes.h"

namespace isosplat::render {

/// Closes the faces at which the clipping cuts the solid, in a copy of the layers. Occlusion
/// queries read the layers without caps: the extent of a cap follows from the surfaces behind it,
/// which therefore have to stay resident. The README's decision 25 describes the passes.
class ClipCaps {
 public:
  /// Copies the layers that the splat passes drew last, in this frame and of this volume alone,
  /// with caps. `layer_of`: the layer of each isosurface of the volume, −1 for those that are not
  /// drawn. `before`: the number of volumes whose caps the copy has already. The new caps are
  /// merged into this copy by depth; with 0, they replace it. `order`: where caps of several
  /// volumes lie in the same face, those with the greatest `order` are in front. Errors: gl_error.
  Result<void> draw(const DrawContext& context, SplatPasses& splat_passes, const SplatFrame& splats,
                    std::span<const int> layer_of, int layers, int before, int order);

  /// The layers with caps.
  SurfaceTargets& targets() { return targets_; }
  uint64_t bytes() const;

  void release();
  /// The context that owned the objects is gone.
  void abandon();

 private:
  struct Ranks;  // the number of each isovalue in ascending order, and the cap of each layer

  Result<void> prepare(int width, int height, int layers);
  Result<void> draw_cut_cells(const DrawContext& context, SplatPasses& splat_passes,
                              const SplatFrame& splats, const Ranks& ranks);
  Result<void> draw_states(const DrawContext& context, const SplatFrame& splats, int layers,
                           const Ranks& ranks);
  Result<void> find_nearest_tiles(const DrawContext& context);
  Result<void> draw_layers(const DrawContext& context, const SplatFrame& splats, int layers,
                           const Ranks& ranks, int before, int order);

  SurfaceTargets targets_;
  ImageTarget cut_cells_{GL_R8UI, "for cut faces"}, states_{GL_R8UI, "for the states of caps"};
  ImageTarget tiles_{GL_RG32UI, "for tiles of caps"};
  ImageTarget nearest_[2] = {{GL_R32UI, "for caps"}, {GL_R32UI, "for caps"}};
  int latest_ = 0;  // of nearest_
};

}  // namespace isosplat::render
