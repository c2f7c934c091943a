#include "shared/render/passes/surface_targets.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosplat::render {
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

Result<void> SurfaceTargets::prepare(int width, int height, int layers) {
  if (width == width_ && height == height_ && layers <= layers_) return {};
  release();
  width_ = width;
  height_ = height;
  layers_ = layers;
  return create_layers();
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

void SurfaceTargets::swap(SurfaceTargets& other) {
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(layers_, other.layers_);
  std::swap(surfaces_, other.surfaces_);
  std::swap(depths_, other.depths_);
  std::swap(framebuffers_, other.framebuffers_);
  std::swap(picture_, other.picture_);
  std::swap(picture_framebuffer_, other.picture_framebuffer_);
  std::swap(bytes_, other.bytes_);
}

void SurfaceTargets::release() {
  if (picture_framebuffer_) glDeleteFramebuffers(1, &picture_framebuffer_);
  if (picture_) glDeleteTextures(1, &picture_);
  if (surfaces_) glDeleteTextures(1, &surfaces_);
  if (depths_) glDeleteTextures(1, &depths_);
  if (!framebuffers_.empty()) {
    glDeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
  }
  abandon();
}

void SurfaceTargets::abandon() {
  width_ = height_ = layers_ = 0;
  surfaces_ = depths_ = picture_ = picture_framebuffer_ = 0;
  framebuffers_.clear();
  bytes_ = 0;
}

}  // namespace isosplat::render
