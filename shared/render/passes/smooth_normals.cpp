#include "shared/render/passes/smooth_normals.h"

#include <cmath>

#include "shared/render/passes/gradient_lattice.h"
#include "shared/render/passes/image_triangle.h"

namespace isosplat::render {

bool has_smooth_normals(const DrawItem& item, uint32_t finest_level, SmoothSizes sizes) {
  const int finer = static_cast<int>(item.chunk->block.level - finest_level);
  return std::ldexp(item.largest_side_px, -finer) > sizes.from_px;
}

void start_smooth_normals(ShaderPrograms& programs, const DrawList& list, float max_point_size) {
  if (GradientLattice::has_one_level(list, kStillSmooth)) {
    programs.prepare({.pass = SplatPass::lattice, .pulled = true});
    programs.prepare(ImagePass::lattice_normals);
    programs.prepare(ImagePass::replace_normals);
    return;
  }
  programs.prepare(ImagePass::positions);
  programs.prepare(ImagePass::smooth_normals);
  for (const DrawItem& item : list.items()) {
    const bool pulled = item.largest_support_px > max_point_size;
    programs.prepare(SplatVariant{.pass = SplatPass::gradients, .pulled = pulled});
  }
}

Result<void> SmoothNormals::prepare(int width, int height, bool float_blend) {
  float_blend_ = float_blend;
  if (auto ok = positions_.prepare(width, height); !ok) return ok;
  return sums().prepare(width, height);
}

Result<void> SmoothNormals::begin(const DrawContext& context, int layer,
                                  std::span<const int> isosurfaces) {
  const auto program = context.programs.image(ImagePass::positions);
  if (!program) return tl::unexpected(program.error());
  const SurfaceTargets& targets = context.targets;
  glBindFramebuffer(GL_FRAMEBUFFER, positions_.framebuffer());
  glViewport(0, 0, positions_.width(), positions_.height());
  glUseProgram((*program)->name());
  glUniform1i((*program)->uniform("u_layer"), layer);
  set_isosurfaces(**program, isosurfaces);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, targets.depths());
  bind_texture(0, GL_TEXTURE_2D_ARRAY, targets.surfaces());
  draw_image_triangle(context);
  // Textures that are drawn into may not be bound.
  bind_texture(1, GL_TEXTURE_2D_ARRAY, 0);
  bind_texture(0, GL_TEXTURE_2D_ARRAY, 0);

  glBindFramebuffer(GL_FRAMEBUFFER, sums().framebuffer());
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, targets.depths(), 0, layer);
  const float zero[4] = {0, 0, 0, 0};
  glClearBufferfv(GL_COLOR, 0, zero);
  return {};
}

Result<void> SmoothNormals::finish(const DrawContext& context, int layer) {
  // The depths may be deleted before the sums.
  glBindFramebuffer(GL_FRAMEBUFFER, sums().framebuffer());
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, 0, 0, 0);
  const auto program = context.programs.image(ImagePass::smooth_normals);
  if (!program) return tl::unexpected(program.error());
  const SurfaceTargets& targets = context.targets;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram((*program)->name());
  bind_texture(1, GL_TEXTURE_2D, sums().texture());
  bind_texture(0, GL_TEXTURE_2D, positions());
  glDisable(GL_DEPTH_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_FALSE, GL_FALSE);  // the two components of the normal
  draw_image_triangle(context);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_DEPTH_TEST);
  bind_texture(1, GL_TEXTURE_2D, 0);
  bind_texture(0, GL_TEXTURE_2D, 0);
  return {};
}

void SmoothNormals::abandon() {
  positions_.abandon();
  sums_32_.abandon();
  sums_16_.abandon();
}

}  // namespace isosplat::render
