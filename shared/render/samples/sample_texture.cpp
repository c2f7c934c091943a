#include "shared/render/samples/sample_texture.h"

#include <algorithm>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {

void SampleTexture::load_field(const SampleBuffers& buffers, const SampleRange& range) {
  load_from(buffers.field_buffer_name(range.buffer), range, FIELD_TEXTURE_UNIT);
}

void SampleTexture::load_from(GLuint buffer, const SampleRange& range, GLuint unit) {
  constexpr int kMinRows = 64;
  const int rows =
      static_cast<int>((range.count + SAMPLE_TEXTURE_WIDTH - 1) / SAMPLE_TEXTURE_WIDTH);
  glActiveTexture(GL_TEXTURE0 + unit);
  if (rows > rows_) {
    release();
    rows_ = std::max(rows, kMinRows);
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, SAMPLE_TEXTURE_WIDTH, rows_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glBindTexture(GL_TEXTURE_2D, texture_);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
  const auto copy_rows = [&](int row, int width, int height) {
    const size_t sample = range.first + size_t(row) * SAMPLE_TEXTURE_WIDTH;
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, row, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                    reinterpret_cast<const void*>(sample * sizeof(PackedSample)));
  };
  const int full_rows = static_cast<int>(range.count / SAMPLE_TEXTURE_WIDTH);
  if (full_rows) copy_rows(0, SAMPLE_TEXTURE_WIDTH, full_rows);
  const int rest = static_cast<int>(range.count % SAMPLE_TEXTURE_WIDTH);
  if (rest) copy_rows(full_rows, rest, 1);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

uint64_t SampleTexture::bytes() const {
  return uint64_t(rows_) * SAMPLE_TEXTURE_WIDTH * sizeof(PackedSample);
}

void SampleTexture::release() {
  if (texture_) glDeleteTextures(1, &texture_);
  abandon();
}

void SampleTexture::abandon() {
  texture_ = 0;
  rows_ = 0;
}

}  // namespace isosplat::render
