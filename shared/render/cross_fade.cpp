#include "shared/render/cross_fade.h"

namespace isosplat {

Result<void> CrossFade::hold(GLuint framebuffer, int width, int height) {
  if (width != width_ || height != height_) {
    release();
    for (Picture& picture : pictures_) {
      glGenTextures(1, &picture.texture);
      glBindTexture(GL_TEXTURE_2D, picture.texture);
      glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, width, height);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      glGenFramebuffers(1, &picture.framebuffer);
      glBindFramebuffer(GL_FRAMEBUFFER, picture.framebuffer);
      glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture.texture,
                             0);
      if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        release();
        return fail(Status::gl_error, "the GPU has no room to keep a picture of this size");
      }
    }
    glBindTexture(GL_TEXTURE_2D, 0);
    width_ = width;
    height_ = height;
  }
  copy(framebuffer, pictures_[0]);
  holds_ = true;
  return {};
}

void CrossFade::turn_to_picture_in(GLuint framebuffer) {
  copy(framebuffer, pictures_[1]);
}

void CrossFade::copy(GLuint framebuffer, const Picture& picture) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, picture.framebuffer);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

void CrossFade::release() {
  for (Picture& picture : pictures_) {
    if (picture.texture) glDeleteTextures(1, &picture.texture);
    if (picture.framebuffer) glDeleteFramebuffers(1, &picture.framebuffer);
  }
  forget();
}

void CrossFade::forget() {
  pictures_[0] = pictures_[1] = {};
  holds_ = false;
  width_ = height_ = 0;
}

}  // namespace isosplat
