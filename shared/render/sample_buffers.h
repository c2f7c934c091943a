#pragma once

#include <GLES3/gl3.h>

#include <map>
#include <span>
#include <vector>

#include "shared/base/status.h"
#include "shared/sampling/packed_sample.h"

namespace isosplat {

/// A run of samples in one of the buffers.
struct SampleRange {
  uint32_t buffer = 0;
  uint32_t first = 0;
  uint32_t count = 0;

  uint64_t offset_bytes() const { return uint64_t{first} * sizeof(PackedSample); }
};

/// The samples of all chunks, in a few large vertex buffers. Ranges are taken first fit; freed
/// neighbours join. Buffers are never moved, so that nothing is copied when chunks come and go, and
/// an empty one is kept for the next chunk.
class SampleBuffers {
 public:
  /// Samples per buffer (8 MiB); a larger chunk gets a buffer of its own size.
  static constexpr uint32_t kBufferSamples = 1u << 19;

  SampleBuffers() = default;
  ~SampleBuffers() { release(); }
  SampleBuffers(const SampleBuffers&) = delete;
  SampleBuffers& operator=(const SampleBuffers&) = delete;

  /// Where a new buffer is needed, waits for the GPU to say whether there is room for it; samples
  /// go to existing ones without a question. Errors: out_of_memory; nothing is kept then.
  Result<SampleRange> add(std::span<const PackedSample> samples);

  /// Like add, but leaves the upload to the caller: the range's buffer is bound to GL_ARRAY_BUFFER,
  /// and the samples belong at range.offset_bytes(). Binds nothing if count is 0.
  Result<SampleRange> reserve(uint32_t count);
  void remove(const SampleRange& range);

  /// Vertex array whose attribute 0 is the buffer's samples (uvec4).
  GLuint vertex_array(uint32_t buffer) const { return buffers_[buffer].vertex_array; }
  GLuint buffer_name(uint32_t buffer) const { return buffers_[buffer].buffer; }

  uint64_t bytes() const;
  uint64_t samples() const { return samples_; }

  /// Deletes all buffers.
  void release();
  /// The context that owned them is gone.
  void abandon();

 private:
  struct Buffer {
    GLuint buffer = 0, vertex_array = 0;
    uint32_t capacity = 0;
    std::map<uint32_t, uint32_t> free;  // first → count
  };
  std::vector<Buffer> buffers_;
  uint64_t samples_ = 0;
};

}  // namespace isosplat
