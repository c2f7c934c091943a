#include "shared/render/gl/image_target.h"

#include <string>

namespace isosplat::render {

Result<void> ImageTarget::prepare(int width, int height) {
  if (has_size(width, height)) return {};
  release();
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexStorage2D(GL_TEXTURE_2D, 1, format_, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  // A texture that is bound and drawn into at once would be a feedback loop.
  glBindTexture(GL_TEXTURE_2D, 0);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  const GLenum attachment =
      format_ == GL_DEPTH_COMPONENT24 ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0;
  glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture_, 0);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    release();
    return fail(Status::gl_error, "the GPU has no room " + std::string(purpose_) + " of " +
                                      std::to_string(width) + " × " + std::to_string(height) +
                                      " px (framebuffer status " + std::to_string(status) +
                                      "): a smaller image may fit");
  }
  width_ = width;
  height_ = height;
  return {};
}

uint64_t ImageTarget::bytes() const {
  uint64_t texel = 4;  // GL_R32UI, GL_RGBA8, GL_DEPTH_COMPONENT24
  if (format_ == GL_R8UI) texel = 1;
  if (format_ == GL_RGBA16F || format_ == GL_RG32UI) texel = 8;
  if (format_ == GL_RGBA32UI) texel = 16;
  return uint64_t(width_) * uint64_t(height_) * texel;
}

void ImageTarget::release() {
  if (texture_) glDeleteTextures(1, &texture_);
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  abandon();
}

void ImageTarget::abandon() {
  texture_ = framebuffer_ = 0;
  width_ = height_ = 0;
}

}  // namespace isosplat::render
