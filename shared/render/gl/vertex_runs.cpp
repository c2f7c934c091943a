#include "shared/render/gl/vertex_runs.h"

#include <cstddef>

#ifdef __EMSCRIPTEN__
#include <webgl/webgl1_ext.h>
#endif

namespace isosplat::render {

void VertexRuns::add(uint32_t first, uint32_t count) {
  firsts_.push_back(static_cast<GLint>(first));
  counts_.push_back(static_cast<GLsizei>(count));
}

uint32_t VertexRuns::draw(GLenum mode, [[maybe_unused]] bool multi_draw) {
  auto calls = static_cast<uint32_t>(firsts_.size());
#ifdef __EMSCRIPTEN__
  if (multi_draw && calls > 1) {
    glMultiDrawArraysWEBGL(mode, firsts_.data(), counts_.data(), static_cast<GLsizei>(calls));
    firsts_.clear();
    calls = 1;
  }
#endif
  for (size_t i = 0; i < firsts_.size(); ++i) glDrawArrays(mode, firsts_[i], counts_[i]);
  firsts_.clear();
  counts_.clear();
  return calls;
}

}  // namespace isosplat::render
