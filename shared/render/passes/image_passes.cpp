#include "shared/render/passes/image_passes.h"

#include <algorithm>

#include "shared/render/passes/image_triangle.h"

namespace isosplat::render {
namespace {

void bind_framebuffer(GLuint framebuffer, int width, int height) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
}

}  // namespace

// Each pass unbinds its textures. Later passes draw into them, and drawing into a bound texture
// would be a feedback loop.

Result<void> compose(const DrawContext& context, int layers, GLuint framebuffer,
                     const StillPicture* still) {
  const SurfaceTargets& targets = context.targets;
  const RenderSettings& settings = context.settings;
  bind_framebuffer(framebuffer, targets.width(), targets.height());
  glDisable(GL_DEPTH_TEST);
  const bool is_occluded = still && Lighting::has_occlusion(settings.light);
  const auto linked = context.programs.compose(
      {layers > 1, settings.eye_dome > 0, is_occluded, is_occluded && still->whole,
       settings.isosurfaces.size() > size_t{kMaxIsosurfaces}, context.field_style});
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  glUseProgram(program.name());
  bind_texture(0, GL_TEXTURE_2D_ARRAY, targets.surfaces());
  bind_texture(1, GL_TEXTURE_2D_ARRAY, targets.depths());
  context.lighting.apply(program, settings, context.isosurfaces);
  Lighting::apply_edges(program, settings, context.image_height);
  if (is_occluded) Lighting::apply_occlusion(program, settings.light, *still);
  if (is_occluded && still->whole) {
    bind_texture(2, GL_TEXTURE_2D_ARRAY, still->whole->depths());
    glUniform1f(program.uniform("u_whole_scale"), static_cast<float>(still->whole->height()) /
                                                      static_cast<float>(context.image_height));
  }
  if (layers > 1) glUniform1i(program.uniform("u_layers"), layers);
  glUniform1i(program.uniform("u_linear"), still != nullptr);
  glUniform1i(program.uniform("u_slice_mapped"),
              settings.slices_mapped || settings.colour_by == ColourBy::isovalue);
  const auto& b = settings.background;
  const Vec3f background = to_linear({b[0], b[1], b[2]});
  glUniform4f(program.uniform("u_background"), background.x, background.y, background.z,
              std::clamp(b[3], 0.0f, 1.0f));
  draw_image_triangle(context);
  bind_texture(2, GL_TEXTURE_2D_ARRAY, 0);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, 0);
  bind_texture(0, GL_TEXTURE_2D_ARRAY, 0);
  return {};
}

Result<void> show_lit_picture(const DrawContext& context, GLuint framebuffer) {
  const SurfaceTargets& targets = context.targets;
  const int width = targets.width(), height = targets.height();
  if (context.settings.eye_dome <= 0) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.picture().framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return {};
  }
  const auto program = context.programs.image(ImagePass::darken);
  if (!program) return tl::unexpected(program.error());
  bind_framebuffer(framebuffer, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  Lighting::apply_edges(**program, context.settings, context.image_height);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, targets.depths());
  bind_texture(0, GL_TEXTURE_2D, targets.picture_colours());
  draw_image_triangle(context);
  bind_texture(0, GL_TEXTURE_2D, 0);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, 0);
  return {};
}

Result<void> present_mean(const DrawContext& context, const Accumulation& accumulation,
                          GLuint framebuffer) {
  const auto program = context.programs.image(ImagePass::present);
  if (!program) return tl::unexpected(program.error());
  bind_framebuffer(framebuffer, context.targets.width(), context.targets.height());
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  bind_texture(0, GL_TEXTURE_2D, accumulation.sums().texture());
  glUniform1f((*program)->uniform("u_weight"), 1.0f / static_cast<float>(accumulation.pictures()));
  draw_image_triangle(context);
  glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

Result<void> show_fade(const DrawContext& context, const CrossFade& cross_fade, float progress,
                       int width, int height, GLuint framebuffer) {
  const auto program = context.programs.image(ImagePass::fade);
  if (!program) return tl::unexpected(program.error());
  bind_framebuffer(framebuffer, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  glUniform1f((*program)->uniform("u_progress"), progress);
  bind_texture(1, GL_TEXTURE_2D, cross_fade.to().texture());
  bind_texture(0, GL_TEXTURE_2D, cross_fade.from().texture());
  glBindVertexArray(context.empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  bind_texture(1, GL_TEXTURE_2D, 0);
  bind_texture(0, GL_TEXTURE_2D, 0);
  return {};
}

}  // namespace isosplat::render
