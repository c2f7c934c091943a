#include "shared/render/occluders.h"

#include "shared/render/shader_constants.h"

namespace isosplat {

Result<void> Occluders::prepare(int width, int height) {
  if (!program_) {
    auto program = GlProgram::link("", {"image.vert.glsl"}, {"occluder_image.frag.glsl"});
    if (!program) return tl::unexpected(program.error());
    program_ = std::move(*program);
  }
  const int columns = (width + OCCLUDER_PX - 1) / OCCLUDER_PX;
  const int rows = (height + OCCLUDER_PX - 1) / OCCLUDER_PX;
  if (auto ok = depths_.prepare(columns, rows); !ok) return ok;
  return image_.prepare(columns, rows);
}

void Occluders::begin() {
  const float farthest = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, depths_.framebuffer());
  glViewport(0, 0, depths_.width(), depths_.height());
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void Occluders::take(GLuint empty_vertex_array) {
  glBindFramebuffer(GL_FRAMEBUFFER, image_.framebuffer());
  glUseProgram(program_.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, depths_.texture());
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D, 0);
}

void Occluders::release() {
  program_ = GlProgram{};
  depths_.release();
  image_.release();
}

void Occluders::forget() {
  program_.forget();
  depths_.forget();
  image_.forget();
}

}  // namespace isosplat
