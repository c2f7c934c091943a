#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <vector>

namespace isosplat::render {

/// Ranges of vertices of the bound vertex array that are drawn with the same GL state.
class VertexRuns {
 public:
  void add(uint32_t first, uint32_t count);

  /// Draws all ranges, and clears the list. `multi_draw`: uses WEBGL_multi_draw, which the context
  /// must support. Returns the number of draw calls.
  uint32_t draw(GLenum mode, bool multi_draw);

 private:
  std::vector<GLint> firsts_;
  std::vector<GLsizei> counts_;
};

}  // namespace isosplat::render
