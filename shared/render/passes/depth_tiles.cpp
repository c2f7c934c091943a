#include "shared/render/passes/depth_tiles.h"

#include <cstring>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {

Result<void> DepthTiles::prepare(int width, int height) {
  if (!program_) {
    auto program = GlProgram::link("", {"image.vert.glsl"}, {"depth_tiles.frag.glsl"});
    if (!program) return tl::unexpected(program.error());
    program_ = std::move(*program);
  }
  return tiles_.prepare((width + HIDING_TILE_PX - 1) / HIDING_TILE_PX,
                        (height + HIDING_TILE_PX - 1) / HIDING_TILE_PX);
}

void DepthTiles::update(const SplatTarget& target, GLuint empty_vertex_array) {
  glBindFramebuffer(GL_FRAMEBUFFER, tiles_.framebuffer());
  glViewport(0, 0, tiles_.width(), tiles_.height());
  glUseProgram(program_.name());
  glUniform1i(program_.uniform("u_layer"), target.layer);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, target.depths);
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
}

const std::vector<float>& DepthTiles::read_farthest() {
  const auto tiles = static_cast<size_t>(tiles_.width()) * static_cast<size_t>(tiles_.height());
  texels_.resize(4 * tiles);
  farthest_.resize(tiles);
  glBindFramebuffer(GL_FRAMEBUFFER, tiles_.framebuffer());
  glReadPixels(0, 0, tiles_.width(), tiles_.height(), GL_RGBA_INTEGER, GL_UNSIGNED_INT,
               texels_.data());
  for (size_t i = 0; i < tiles; ++i) std::memcpy(&farthest_[i], &texels_[4 * i], sizeof(float));
  return farthest_;
}

void DepthTiles::release() {
  program_ = GlProgram{};
  tiles_.release();
}

void DepthTiles::abandon() {
  program_.abandon();
  tiles_.abandon();
}

}  // namespace isosplat::render
