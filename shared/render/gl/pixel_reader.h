#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <span>

namespace isosplat::render {

/// Reads a rectangle of the bound framebuffer (RGBA8, premultiplied) as RGBA, alpha not
/// premultiplied, rows from the top. Waits for the GPU. `rgba`: 4 × width × height bytes.
void read_straight_pixels(GLint left, GLint bottom, int width, int height, std::span<uint8_t> rgba);

}  // namespace isosplat::render
