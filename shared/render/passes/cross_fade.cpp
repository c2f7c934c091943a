#include "shared/render/passes/cross_fade.h"

namespace isosplat::render {

Result<void> CrossFade::set_from(GLuint framebuffer, int width, int height) {
  has_from_ = false;
  for (ImageTarget& picture : pictures_) {
    if (auto ok = picture.prepare(width, height); !ok) return ok;
  }
  copy(framebuffer, from());
  has_from_ = true;
  return {};
}

void CrossFade::set_to(GLuint framebuffer) {
  copy(framebuffer, to());
}

void CrossFade::copy(GLuint framebuffer, const ImageTarget& picture) const {
  const int width = picture.width(), height = picture.height();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, picture.framebuffer());
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

void CrossFade::release() {
  for (ImageTarget& picture : pictures_) picture.release();
  has_from_ = false;
}

void CrossFade::abandon() {
  for (ImageTarget& picture : pictures_) picture.abandon();
  has_from_ = false;
}

}  // namespace isosplat::render
