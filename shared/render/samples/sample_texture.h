#pragma once

#include <GLES3/gl3.h>

#include <cstdint>

#include "shared/render/samples/sample_buffers.h"

namespace isosplat::render {

/// A texture with the samples of one chunk, or with the values of a field for them, from which
/// vertex shaders fetch them by index. It serves splats that are too large for points.
class SampleTexture {
 public:
  SampleTexture() = default;
  ~SampleTexture() { release(); }
  SampleTexture(const SampleTexture&) = delete;
  SampleTexture& operator=(const SampleTexture&) = delete;

  /// Copies samples from their buffer on the GPU, and leaves the texture bound to unit 0.
  void load(const SampleBuffers& buffers, const SampleRange& range) {
    load_from(buffers.buffer_name(range.buffer), range, 0);
  }
  /// The same with the field values of the range, bound to FIELD_TEXTURE_UNIT.
  void load_field(const SampleBuffers& buffers, const SampleRange& range);

  uint64_t bytes() const;

  void release();
  /// The context that owned the texture is gone.
  void abandon();

 private:
  void load_from(GLuint buffer, const SampleRange& range, GLuint unit);

  GLuint texture_ = 0;
  int rows_ = 0;
};

}  // namespace isosplat::render
