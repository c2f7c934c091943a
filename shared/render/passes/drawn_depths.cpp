#include "shared/render/passes/drawn_depths.h"

namespace isosplat::render {

void DrawnDepths::copy_from(const SplatTarget& target) {
  const int width = depths_.width(), height = depths_.height();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, depths_.framebuffer());
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
}

}  // namespace isosplat::render
