#include "shared/render/samples/sample_buffers.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#ifdef __EMSCRIPTEN__
// WebGL 2 reads buffers by copying, not by mapping; Emscripten's headers do not declare it.
extern "C" void glGetBufferSubData(GLenum target, GLintptr offset, GLsizeiptr size, void* data);
#endif

namespace isosplat::render {

SampleRange SampleBuffers::add(std::span<const PackedSample> samples) {
  const SampleRange range = reserve(static_cast<uint32_t>(samples.size()));
  if (range.count > 0) {
    glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(range.offset_bytes()),
                    static_cast<GLsizeiptr>(samples.size_bytes()), samples.data());
  }
  return range;
}

SampleRange SampleBuffers::reserve(uint32_t count) {
  if (count == 0) return SampleRange{};
  uint32_t index = 0;
  std::map<uint32_t, uint32_t>::iterator run;
  for (; index < buffers_.size(); ++index) {
    auto& free = buffers_[index].free;
    run = std::find_if(free.begin(), free.end(), [&](const auto& r) { return r.second >= count; });
    if (run != free.end()) break;
  }
  if (index == buffers_.size()) {
    Buffer made;
    made.capacity = std::max(count, kBufferSamples);
    glGenBuffers(1, &made.buffer);
    glGenVertexArrays(1, &made.vertex_array);
    glBindVertexArray(made.vertex_array);
    glBindBuffer(GL_ARRAY_BUFFER, made.buffer);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(made.capacity * sizeof(PackedSample)),
                 nullptr, GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribIPointer(0, 4, GL_UNSIGNED_INT, sizeof(PackedSample), nullptr);
    glBindVertexArray(0);
    made.free[0] = made.capacity;
    buffers_.push_back(std::move(made));
    run = buffers_.back().free.begin();
  }
  Buffer& buffer = buffers_[index];
  const SampleRange range{index, run->first, count, ++last_serial_};
  const uint32_t left = run->second - count;
  buffer.free.erase(run);
  if (left) buffer.free[range.first + count] = left;
  glBindBuffer(GL_ARRAY_BUFFER, buffer.buffer);
  samples_ += count;
  return range;
}

void SampleBuffers::remove(const SampleRange& range) {
  if (range.count == 0 || range.buffer >= buffers_.size()) return;
  auto& free = buffers_[range.buffer].free;
  auto run = free.emplace(range.first, range.count).first;
  if (const auto next = std::next(run);
      next != free.end() && run->first + run->second == next->first) {
    run->second += next->second;
    free.erase(next);
  }
  if (run != free.begin()) {
    const auto previous = std::prev(run);
    if (previous->first + previous->second == run->first) {
      previous->second += run->second;
      free.erase(run);
    }
  }
  samples_ -= range.count;
}

void SampleBuffers::reserve_field(const SampleRange& range) {
  static_assert(sizeof(PackedField) == sizeof(PackedSample));  // for SampleRange::offset_bytes
  if (range.count == 0 || range.buffer >= buffers_.size()) return;
  Buffer& buffer = buffers_[range.buffer];
  if (!buffer.field) {
    glGenBuffers(1, &buffer.field);
    glBindVertexArray(buffer.vertex_array);
    glBindBuffer(GL_ARRAY_BUFFER, buffer.field);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(buffer.capacity * sizeof(PackedField)),
                 nullptr, GL_STATIC_DRAW);
    glEnableVertexAttribArray(1);
    glVertexAttribIPointer(1, 4, GL_UNSIGNED_INT, sizeof(PackedField), nullptr);
    glBindVertexArray(0);
    buffer.is_field_confirmed = false;
  }
  glBindBuffer(GL_ARRAY_BUFFER, buffer.field);
  buffer.field_samples += range.count;
}

void SampleBuffers::remove_field(const SampleRange& range) {
  if (range.count == 0 || range.buffer >= buffers_.size()) return;
  Buffer& buffer = buffers_[range.buffer];
  buffer.field_samples -= range.count;
  if (buffer.field_samples == 0) delete_field(buffer);
}

void SampleBuffers::delete_field(Buffer& buffer) {
  if (!buffer.field) return;
  // Buffers are only detached from the vertex array that is bound.
  glBindVertexArray(buffer.vertex_array);
  glDisableVertexAttribArray(1);
  glDeleteBuffers(1, &buffer.field);
  glBindVertexArray(0);
  buffer.field = 0;
  buffer.field_samples = 0;
}

void SampleBuffers::confirm() {
  confirmed_ = buffers_.size();
  for (Buffer& buffer : buffers_) buffer.is_field_confirmed = buffer.field != 0;
}

void SampleBuffers::drop_unconfirmed() {
  for (Buffer& buffer : buffers_) {
    if (!buffer.is_field_confirmed) delete_field(buffer);
  }
  while (buffers_.size() > confirmed_) {
    delete_field(buffers_.back());
    glDeleteVertexArrays(1, &buffers_.back().vertex_array);
    glDeleteBuffers(1, &buffers_.back().buffer);
    buffers_.pop_back();
  }
}

void SampleBuffers::read_from(GLuint buffer, const SampleRange& range, uint32_t first,
                              std::span<std::byte> out) {
  if (out.empty() || buffer == 0) return;
  const auto offset =
      static_cast<GLintptr>(range.offset_bytes() + uint64_t{first} * sizeof(PackedSample));
  const auto size = static_cast<GLsizeiptr>(out.size());
  glBindBuffer(GL_COPY_READ_BUFFER, buffer);
#ifdef __EMSCRIPTEN__
  glGetBufferSubData(GL_COPY_READ_BUFFER, offset, size, out.data());
#else
  if (const void* mapped = glMapBufferRange(GL_COPY_READ_BUFFER, offset, size, GL_MAP_READ_BIT)) {
    std::memcpy(out.data(), mapped, out.size());
    glUnmapBuffer(GL_COPY_READ_BUFFER);
  }
#endif
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
}

uint64_t SampleBuffers::bytes() const {
  uint64_t sum = 0;
  for (const Buffer& buffer : buffers_) {
    sum += uint64_t{buffer.capacity} *
           (sizeof(PackedSample) + (buffer.field ? sizeof(PackedField) : 0));
  }
  return sum;
}

void SampleBuffers::release() {
  confirmed_ = 0;
  drop_unconfirmed();
  abandon();
}

void SampleBuffers::abandon() {
  buffers_.clear();
  confirmed_ = 0;
  samples_ = 0;
}

}  // namespace isosplat::render
