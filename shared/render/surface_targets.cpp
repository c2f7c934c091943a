#include "shared/render/surface_targets.h"

#include <algorithm>
#include <string>

namespace isosplat {
namespace {

void set_nearest_and_clamped(GLenum target) {
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

Result<void> check_complete(const char* what) {
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return {};
  return fail(Status::gl_error, std::string("the framebuffer for ") + what +
                                    " is not complete (status " + std::to_string(status) +
                                    "): a smaller image may fit");
}

}  // namespace

Result<void> SurfaceTargets::prepare(int width, int height, int layers, bool blended,
                                     bool float_blend) {
  if (width != width_ || height != height_ || layers > layers_) {
    release();
    width_ = width;
    height_ = height;
    layers_ = layers;
    if (auto ok = create_layers(); !ok) return ok;
  }
  if (blended && !sums_framebuffer_) return create_sums(float_blend);
  return {};
}

Result<void> SurfaceTargets::create_layers() {
  glGenTextures(1, &surfaces_);
  glBindTexture(GL_TEXTURE_2D_ARRAY, surfaces_);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_RGBA16UI, width_, height_, layers_);
  set_nearest_and_clamped(GL_TEXTURE_2D_ARRAY);
  glGenTextures(1, &depths_);
  glBindTexture(GL_TEXTURE_2D_ARRAY, depths_);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_DEPTH_COMPONENT24, width_, height_, layers_);
  set_nearest_and_clamped(GL_TEXTURE_2D_ARRAY);
  framebuffers_.resize(static_cast<size_t>(layers_));
  glGenFramebuffers(layers_, framebuffers_.data());
  for (int layer = 0; layer < layers_; ++layer) {
    glBindFramebuffer(GL_FRAMEBUFFER, layer_framebuffer(layer));
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, surfaces_, 0, layer);
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depths_, 0, layer);
    if (auto ok = check_complete("surfaces"); !ok) return ok;
  }
  bytes_ = uint64_t(width_) * uint64_t(height_) * uint64_t(layers_) * 12;
  return {};
}

Result<void> SurfaceTargets::create_sums(bool float_blend) {
  glGenFramebuffers(1, &sums_framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, sums_framebuffer_);
  glGenTextures(2, sums_);
  for (int i = 0; i < 2; ++i) {
    glBindTexture(GL_TEXTURE_2D, sums_[i]);
    glTexStorage2D(GL_TEXTURE_2D, 1, float_blend ? GL_RGBA32F : GL_RGBA16F, width_, height_);
    set_nearest_and_clamped(GL_TEXTURE_2D);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i),
                           GL_TEXTURE_2D, sums_[i], 0);
  }
  glGenTextures(1, &sums_depth_);
  glBindTexture(GL_TEXTURE_2D_ARRAY, sums_depth_);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_DEPTH_COMPONENT24, width_, height_, 1);
  set_nearest_and_clamped(GL_TEXTURE_2D_ARRAY);
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, sums_depth_, 0, 0);
  const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, both);
  if (auto ok = check_complete("blending"); !ok) return ok;
  bytes_ += uint64_t(width_) * uint64_t(height_) * (float_blend ? 36u : 20u);
  return {};
}

Result<void> SurfaceTargets::prepare_picture() {
  if (picture_framebuffer_) return {};
  glGenFramebuffers(1, &picture_framebuffer_);
  glGenTextures(1, &picture_);
  glBindTexture(GL_TEXTURE_2D, picture_);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, width_, height_);
  set_nearest_and_clamped(GL_TEXTURE_2D);
  glBindTexture(GL_TEXTURE_2D, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_framebuffer_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_, 0);
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depths_, 0, 0);
  bytes_ += uint64_t(width_) * uint64_t(height_) * 4;
  return check_complete("pictures");
}

void SurfaceTargets::release() {
  if (picture_framebuffer_) glDeleteFramebuffers(1, &picture_framebuffer_);
  if (picture_) glDeleteTextures(1, &picture_);
  if (surfaces_) glDeleteTextures(1, &surfaces_);
  if (depths_) glDeleteTextures(1, &depths_);
  if (!framebuffers_.empty()) {
    glDeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
  }
  if (sums_framebuffer_) glDeleteFramebuffers(1, &sums_framebuffer_);
  if (sums_[0]) glDeleteTextures(2, sums_);
  if (sums_depth_) glDeleteTextures(1, &sums_depth_);
  abandon();
}

void SurfaceTargets::abandon() {
  width_ = height_ = layers_ = 0;
  surfaces_ = depths_ = picture_ = picture_framebuffer_ = sums_framebuffer_ = sums_[0] = sums_[1] =
      sums_depth_ = 0;
  framebuffers_.clear();
  bytes_ = 0;
}

}  // namespace isosplat
