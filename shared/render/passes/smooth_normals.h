#pragma once

#include <span>

#include "shared/render/frame/draw_list.h"
#include "shared/render/gl/image_target.h"
#include "shared/render/passes/draw_context.h"

namespace isosplat::render {

/// Which cells have smooth normals, by the side in px of the finest cells at their position. Up to
/// `from_px`, no cell has them; from `full_px` on, all cells have them; between, normals are mixed.
struct SmoothSizes {
  float from_px, full_px;
};
/// Smaller cells cost more and show less: draw() smooths cells of some pixels. In a still picture,
/// stripes are visible down to the size of a pixel.
inline constexpr SmoothSizes kDrawnSmooth{3, 4}, kStillSmooth{0.5f, 1};

/// Whether the finest drawn cells would be large enough for smooth normals at the position of this
/// item.
bool has_smooth_normals(const DrawItem& item, uint32_t finest_level, SmoothSizes sizes);

/// Starts to compile the programs of the smooth normals of these chunks.
void start_smooth_normals(ShaderPrograms& programs, const DrawList& list, float max_point_size);

/// The images of the smooth normals of one layer: the position of each pixel's surface, and the
/// sums of the gradients around it, which SplatPasses::smooth_normals() draws (README.md, decision
/// 22).
class SmoothNormals {
 public:
  /// Allocates the images. float_blend: 32-bit sums, else 16-bit. Errors: gl_error.
  Result<void> prepare(int width, int height, bool float_blend);

  /// Computes the positions of a layer's surface pixels that show these isosurfaces, at most
  /// kMaxIsosurfaces, clears the sums, and binds the framebuffer of the sums, which has the layer's
  /// depths. Errors: gl_error.
  Result<void> begin(const DrawContext& context, int layer, std::span<const int> isosurfaces);

  /// Replaces the normals of the layer's surface pixels by those of the sums. Errors: gl_error.
  Result<void> finish(const DrawContext& context, int layer);

  /// RGBA32UI: shaders/positions.frag.glsl.
  GLuint positions() const { return positions_.texture(); }
  uint64_t bytes() const { return positions_.bytes() + sums_32_.bytes() + sums_16_.bytes(); }

  void abandon();

 private:
  ImageTarget& sums() { return float_blend_ ? sums_32_ : sums_16_; }

  ImageTarget positions_{GL_RGBA32UI, "for the positions of surfaces"};
  ImageTarget sums_32_{GL_RGBA32F, "for smooth normals"};
  ImageTarget sums_16_{GL_RGBA16F, "for smooth normals"};
  bool float_blend_ = false;
};

}  // namespace isosplat::render
