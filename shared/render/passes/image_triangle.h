#pragma once

#include "shared/render/passes/draw_context.h"

// Passes over all pixels of an image.
namespace isosplat::render {

/// unit: from 0 on. It stays the active one.
inline void bind_texture(GLenum unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(target, texture);
}

/// Draws the triangle that covers the image, with the program in use, and counts the draw call.
inline void draw_image_triangle(const DrawContext& context) {
  glBindVertexArray(context.empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  ++context.statistics.draw_calls;
}

}  // namespace isosplat::render
