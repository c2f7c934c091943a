#include "shared/render/occluders.h"

#include "shared/render/shader_constants.h"

namespace isosplat {

Result<void> Occluders::prepare(int width, int height) {
  const int columns = (width + OCCLUDER_PX - 1) / OCCLUDER_PX;
  const int rows = (height + OCCLUDER_PX - 1) / OCCLUDER_PX;
  if (columns != columns_ || rows != rows_) {
    release();
    auto program = GlProgram::link("", {"image.vert.glsl"}, {"occluder_image.frag.glsl"});
    if (!program) return tl::unexpected(program.error());
    program_ = std::move(*program);
    glGenTextures(1, &image_);
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, image_);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_R32UI, columns, rows);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glGenFramebuffers(1, &image_framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, image_framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, image_, 0);
    glGenTextures(1, &depths_);
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, depths_);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT24, columns, rows);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glBindTexture(GL_TEXTURE_2D, 0);
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths_, 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      release();
      return fail(Status::gl_error, "the framebuffer for occluders is not complete");
    }
    columns_ = columns;
    rows_ = rows;
  }
  return {};
}

void Occluders::begin() {
  const float farthest = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, columns_, rows_);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void Occluders::take(GLuint empty_vertex_array) {
  glBindFramebuffer(GL_FRAMEBUFFER, image_framebuffer_);
  glUseProgram(program_.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, depths_);
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D, 0);
}

void Occluders::release() {
  if (image_) glDeleteTextures(1, &image_);
  if (image_framebuffer_) glDeleteFramebuffers(1, &image_framebuffer_);
  program_ = GlProgram{};
  if (depths_) glDeleteTextures(1, &depths_);
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  forget();
}

void Occluders::forget() {
  program_.forget();
  depths_ = framebuffer_ = image_ = image_framebuffer_ = 0;
  columns_ = rows_ = 0;
}

}  // namespace isosplat
