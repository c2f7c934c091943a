#include "shared/render/depth_tiles.h"

#include <algorithm>

#include "shared/render/shader_constants.h"

namespace isosplat {

Result<void> DepthTiles::prepare(int width, int height) {
  if (!program_) {
    auto program = GlProgram::link("", {"image.vert.glsl"}, {"depth_tiles.frag.glsl"});
    if (!program) return tl::unexpected(program.error());
    program_ = std::move(*program);
    glGenFramebuffers(1, &framebuffer_);
  }
  const int columns = (width + HIDING_TILE_PX - 1) / HIDING_TILE_PX;
  const int rows = (height + HIDING_TILE_PX - 1) / HIDING_TILE_PX;
  if (columns != columns_ || rows != rows_) {
    columns_ = columns;
    rows_ = rows;
    if (texture_) glDeleteTextures(1, &texture_);
    glGenTextures(1, &texture_);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_R32UI, columns_, rows_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
  }
  return {};
}

void DepthTiles::take(const SplatTarget& target, GLuint empty_vertex_array) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, columns_, rows_);
  glUseProgram(program_.name());
  glUniform1i(program_.uniform("u_layer"), target.layer);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, target.depths);
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
}

void DepthTiles::release() {
  if (texture_) glDeleteTextures(1, &texture_);
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  program_ = GlProgram{};
  forget();
}

void DepthTiles::forget() {
  program_.forget();
  texture_ = framebuffer_ = 0;
  columns_ = rows_ = 0;
}

}  // namespace isosplat
