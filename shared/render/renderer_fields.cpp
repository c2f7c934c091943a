#include <GLES3/gl3.h>

#include <string>

#include "shared/render/renderer_state.h"

namespace isosplat::render {

Result<void> Renderer::set_field(const std::optional<ValueMapping>& field, VolumeId volume) {
  State& s = *state_;
  Volume* found = s.find_volume(volume);
  if (!found) {
    return fail(Status::invalid_argument,
                "a field was set before its volume: set the volume first");
  }
  if (!s.lost) found->chunks.clear_fields();
  found->field = field;
  if (s.settings.colour_by == ColourBy::field) s.dirty = true;
  return {};
}

Result<SampleRange> Renderer::bind_samples(ChunkHandle handle, VolumeId volume) const {
  const State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost: it has no samples");
  const Volume* found = s.find_volume(volume);
  const ChunkStore::Chunk* chunk = found ? found->chunks.find(handle) : nullptr;
  if (!chunk) {
    return fail(Status::invalid_argument, "a chunk was read that is not on the GPU: add it first");
  }
  if (chunk->range.count > 0) {
    glBindBuffer(GL_ARRAY_BUFFER, s.buffers.buffer_name(chunk->range.buffer));
  }
  return chunk->range;
}

Result<uint64_t> Renderer::reserve_chunk_field(ChunkHandle handle, uint64_t samples,
                                               VolumeId volume) {
  State& s = *state_;
  if (s.lost) {
    return fail(Status::gl_error, "the GL context is lost: add the field's values again later");
  }
  Volume* found = s.find_volume(volume);
  const ChunkStore::Chunk* chunk = found ? found->chunks.find(handle) : nullptr;
  if (!found || !found->field || !chunk) {
    return fail(Status::invalid_argument,
                "values of a field were added before the field or their chunk: set the field of "
                "the volume, and add the chunk first");
  }
  if (samples != chunk->range.count) {
    return fail(Status::invalid_argument, "expected a value of the field for each of the chunk's " +
                                              std::to_string(chunk->range.count) +
                                              " samples, found " + std::to_string(samples) +
                                              ": decode them with the same chunk");
  }
  const SampleRange range = found->chunks.reserve_field(handle);
  if (found->chunks.is_visible(handle) && s.settings.colour_by == ColourBy::field) s.dirty = true;
  return range.offset_bytes();
}

Result<void> Renderer::set_chunk_field(ChunkHandle handle, std::span<const PackedField> values,
                                       VolumeId volume) {
  const auto offset = reserve_chunk_field(handle, values.size(), volume);
  if (!offset) return tl::unexpected(offset.error());
  if (!values.empty()) {
    glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(*offset),
                    static_cast<GLsizeiptr>(values.size_bytes()), values.data());
  }
  return {};
}

}  // namespace isosplat::render
