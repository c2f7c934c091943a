#pragma once

#include <GLES3/gl3.h>

#include <cstdint>

#include "shared/render/samples/sample_buffers.h"

namespace isosplat::render {

/// A texture with the samples of one chunk, from which vertex shaders fetch them by index. It
/// serves splats that are too large for points.
class SampleTexture {
 public:
  SampleTexture() = default;
  ~SampleTexture() { release(); }
  SampleTexture(const SampleTexture&) = delete;
  SampleTexture& operator=(const SampleTexture&) = delete;

  /// Copies samples from their buffer on the GPU, and leaves the texture bound to unit 0.
  void load(const SampleBuffers& buffers, const SampleRange& range);

  uint64_t bytes() const;

  void release();
  /// The context that owned the texture is gone.
  void abandon();

 private:
  GLuint texture_ = 0;
  int rows_ = 0;
};

}  // namespace isosplat::render
