#pragma once

#include <GLES3/gl3.h>

#include <map>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/sampling/packed_sample.h"

namespace isosplat::render {

/// A range of samples in one of the buffers.
struct SampleRange {
  uint32_t buffer = 0;
  uint32_t first = 0;
  uint32_t count = 0;
  uint64_t serial = 0;  ///< differs from those of all earlier ranges

  uint64_t offset_bytes() const { return uint64_t{first} * sizeof(PackedSample); }
};

/// The samples of all chunks, in a few large vertex buffers. Allocation is first fit; adjacent free
/// ranges are merged. Buffers are never moved or compacted, and empty ones are kept for later
/// chunks.
class SampleBuffers {
 public:
  /// Samples per buffer (8 MiB); a larger chunk gets a buffer of the chunk's size.
  static constexpr uint32_t kBufferSamples = 1u << 19;

  SampleBuffers() = default;
  ~SampleBuffers() { release(); }
  SampleBuffers(const SampleBuffers&) = delete;
  SampleBuffers& operator=(const SampleBuffers&) = delete;

  /// Uploads samples. May make a new buffer, for which the GPU may have no memory: see confirm().
  SampleRange add(std::span<const PackedSample> samples);

  /// Like add, but leaves the upload to the caller: the range's buffer is bound to GL_ARRAY_BUFFER,
  /// and the samples belong at range.offset_bytes(). Binds nothing if count is 0.
  SampleRange reserve(uint32_t count);
  void remove(const SampleRange& range);

  /// Call it when GL has reported no lack of memory since the last buffer was created
  /// (Renderer::check_gpu): all buffers so far then have memory.
  void confirm() { confirmed_ = buffers_.size(); }
  bool is_confirmed(const SampleRange& range) const {
    return range.count == 0 || range.buffer < confirmed_;
  }
  /// Deletes all buffers that are not confirmed. The caller has removed their ranges.
  void drop_unconfirmed();

  /// Copies samples of a range back, from its sample `first` on. Waits for the GPU.
  void read(const SampleRange& range, uint32_t first, std::span<PackedSample> samples) const;

  /// Vertex array with the buffer's samples as attribute 0 (uvec4).
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
    std::map<uint32_t, uint32_t> free;  // free ranges: first → count
  };
  std::vector<Buffer> buffers_;
  size_t confirmed_ = 0;  ///< the number of confirmed buffers, which come first in buffers_
  uint64_t samples_ = 0;
  uint64_t last_serial_ = 0;
};

}  // namespace isosplat::render
