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

void SampleBuffers::drop_unconfirmed() {
  while (buffers_.size() > confirmed_) {
    glDeleteVertexArrays(1, &buffers_.back().vertex_array);
    glDeleteBuffers(1, &buffers_.back().buffer);
    buffers_.pop_back();
  }
}

void SampleBuffers::read(const SampleRange& range, uint32_t first,
                         std::span<PackedSample> samples) const {
  if (samples.empty() || range.buffer >= buffers_.size()) return;
  const auto offset =
      static_cast<GLintptr>(range.offset_bytes() + uint64_t{first} * sizeof(PackedSample));
  const auto size = static_cast<GLsizeiptr>(samples.size_bytes());
  glBindBuffer(GL_COPY_READ_BUFFER, buffers_[range.buffer].buffer);
#ifdef __EMSCRIPTEN__
  glGetBufferSubData(GL_COPY_READ_BUFFER, offset, size, samples.data());
#else
  if (const void* mapped = glMapBufferRange(GL_COPY_READ_BUFFER, offset, size, GL_MAP_READ_BIT)) {
    std::memcpy(static_cast<void*>(samples.data()), mapped, samples.size_bytes());
    glUnmapBuffer(GL_COPY_READ_BUFFER);
  }
#endif
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
}

uint64_t SampleBuffers::bytes() const {
  uint64_t sum = 0;
  for (const Buffer& buffer : buffers_) sum += uint64_t{buffer.capacity} * sizeof(PackedSample);
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
