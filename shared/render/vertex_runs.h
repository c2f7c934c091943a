#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <vector>

namespace isosplat {

/// Runs of vertices of the bound vertex array that are drawn in the same state.
class VertexRuns {
 public:
  void add(uint32_t first, uint32_t count);

  /// Draws all, and forgets them. `together`: by WEBGL_multi_draw, which the context must offer.
  /// Answers the number of calls.
  uint32_t draw(GLenum mode, bool together);

 private:
  std::vector<GLint> firsts_;
  std::vector<GLsizei> counts_;
};

}  // namespace isosplat
