#pragma once

#include <GLES3/gl3.h>

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/sampling/packed_field.h"
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
///
/// A range can have field values as well: one PackedField for each sample, at the same offset in a
/// second buffer, which exists while any range in it has values.
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
  /// Removes samples. The caller has removed their field values.
  void remove(const SampleRange& range);

  /// Makes room for the field values of a range that has none, and binds their buffer to
  /// GL_ARRAY_BUFFER, as reserve() does. They belong at range.offset_bytes() as well.
  void reserve_field(const SampleRange& range);
  /// Binds the buffer of the field values of a range that has some, to replace them.
  void bind_field(const SampleRange& range) const {
    if (range.count > 0) glBindBuffer(GL_ARRAY_BUFFER, field_buffer_of(range));
  }
  /// Removes the field values of a range that has some.
  void remove_field(const SampleRange& range);

  /// Call it when GL has reported no lack of memory since the last buffer was created
  /// (Renderer::check_gpu): all buffers so far then have memory.
  void confirm();
  bool is_confirmed(const SampleRange& range) const {
    return range.count == 0 || range.buffer < confirmed_;
  }
  /// Whether the buffer of the range's field values is confirmed. The range has field values.
  bool is_field_confirmed(const SampleRange& range) const {
    return range.count == 0 || buffers_[range.buffer].is_field_confirmed;
  }
  /// Deletes all buffers that are not confirmed. The caller has removed their ranges and values.
  void drop_unconfirmed();

  /// Copies samples of a range back, from its sample `first` on. Waits for the GPU.
  void read(const SampleRange& range, uint32_t first, std::span<PackedSample> samples) const {
    read_from(buffer_of(range), range, first, std::as_writable_bytes(samples));
  }
  /// The same of the field values of a range that has some.
  void read_field(const SampleRange& range, uint32_t first, std::span<PackedField> values) const {
    read_from(field_buffer_of(range), range, first, std::as_writable_bytes(values));
  }

  /// Vertex array with the buffer's samples as attribute 0, and their field values as attribute 1
  /// if there are any (both uvec4).
  GLuint vertex_array(uint32_t buffer) const { return buffers_[buffer].vertex_array; }
  GLuint buffer_name(uint32_t buffer) const { return buffers_[buffer].buffer; }
  /// 0 if no range of the buffer has field values.
  GLuint field_buffer_name(uint32_t buffer) const { return buffers_[buffer].field; }

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
    GLuint field = 0;            // with the field values
    uint32_t field_samples = 0;  // samples with field values
    bool is_field_confirmed = false;
    std::map<uint32_t, uint32_t> free;  // free ranges: first → count
  };
  static void delete_field(Buffer& buffer);
  GLuint buffer_of(const SampleRange& range) const {
    return range.buffer < buffers_.size() ? buffers_[range.buffer].buffer : 0;
  }
  GLuint field_buffer_of(const SampleRange& range) const {
    return range.buffer < buffers_.size() ? buffers_[range.buffer].field : 0;
  }
  static void read_from(GLuint buffer, const SampleRange& range, uint32_t first,
                        std::span<std::byte> out);

  std::vector<Buffer> buffers_;
  size_t confirmed_ = 0;  ///< the number of confirmed buffers, which come first in buffers_
  uint64_t samples_ = 0;
  uint64_t last_serial_ = 0;
};

}  // namespace isosplat::render
