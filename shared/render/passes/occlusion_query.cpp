#include "shared/render/passes/occlusion_query.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "shared/render/passes/shader_programs.h"
#include "shared/render/shaders/shader_constants.h"

#ifdef __EMSCRIPTEN__
// WebGL 2 reads buffers by copying, not by mapping; Emscripten's headers do not declare it.
extern "C" void glGetBufferSubData(GLenum target, GLintptr offset, GLsizeiptr size, void* data);
#endif

namespace isosplat::render {
namespace {

constexpr size_t kMaxItems = 1024;
constexpr size_t kRowBytes = 4 * OCCLUSION_ROW_TEXELS;
static_assert(kRowBytes == kBlockRegions * kBlockRegions * kBlockRegions);

int power_of_two_above(int number) {
  int power = 1;
  while (power < number) power *= 2;
  return power;
}

/// Copies the first bytes of the bound pixel pack buffer.
void read_pack_buffer(std::vector<uint8_t>& bytes) {
#ifdef __EMSCRIPTEN__
  glGetBufferSubData(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(bytes.size()), bytes.data());
#else
  const auto size = static_cast<GLsizeiptr>(bytes.size());
  if (const void* mapped = glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, size, GL_MAP_READ_BIT)) {
    std::memcpy(bytes.data(), mapped, bytes.size());
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
  }
#endif
}

}  // namespace

Result<void> OcclusionQuery::link(bool orthographic, GLuint frame_binding) {
  if (program_ && orthographic == orthographic_) return {};
  program_ = GlProgram{};
  orthographic_ = orthographic;
  auto program = GlProgram::link(
      orthographic ? kOrthographicDefine : "",
      {"frame.glsl", "cell.glsl", "block.glsl", "regions.glsl", "occlusion.vert.glsl"},
      {"occlusion.frag.glsl"});
  if (!program) return tl::unexpected(program.error());
  program_ = std::move(*program);
  const GLuint name = program_.name();
  glUniformBlockBinding(name, glGetUniformBlockIndex(name, "Frame"), frame_binding);
  return {};
}

Result<void> OcclusionQuery::prepare_counts(int rows) {
  if (!read_buffer_) glGenBuffers(1, &read_buffer_);
  if (rows <= counts_.height()) return {};
  return counts_.prepare(OCCLUSION_ROW_TEXELS, power_of_two_above(rows));
}

void OcclusionQuery::bind_picture(const Picture& picture) const {
  glUseProgram(program_.name());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, picture.farthest_depths);
  glUniform1i(program_.uniform("u_farthest"), 1);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, picture.depths);
  glUniform1i(program_.uniform("u_depths"), 0);
  glUniform1i(program_.uniform("u_in_front"), min_px_ == 0);
  glUniform1i(program_.uniform("u_layers"), picture.layers);
  const auto isosurfaces = static_cast<GLsizei>(picture.quantized_isovalues.size());
  glUniform1i(program_.uniform("u_isovalue_count"), isosurfaces);
  if (isosurfaces == 0) return;
  glUniform1fv(program_.uniform("u_quantized_isovalues"), isosurfaces,
               picture.quantized_isovalues.data());
  glUniform1iv(program_.uniform("u_isosurface_layers"), isosurfaces,
               picture.isosurface_layers.data());
}

void OcclusionQuery::draw_items(const std::vector<Item>& items, size_t tested) const {
  const GLint block = program_.uniform("u_block"), regions = program_.uniform("u_regions"),
              row = program_.uniform("u_row");
  glUniform1f(program_.uniform("u_rows"), static_cast<float>(counts_.height()));
  for (size_t i = 0; i < tested; ++i) {
    const Item& item = items[i];
    if (item.count == 0) continue;
    glUniform4fv(block, 1, item.block.data());
    glUniform4uiv(regions, 4, item.regions.words().data());
    glUniform1f(row, static_cast<float>(i) + 0.5f);
    glBindVertexArray(item.vertex_array);
    glDrawArrays(GL_POINTS, item.first, item.count);
  }
}

void OcclusionQuery::start_reading(int rows) {
  glBindBuffer(GL_PIXEL_PACK_BUFFER, read_buffer_);
  // Allocates new storage for each query: browsers prefetch from buffers that are written once.
  glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(kRowBytes * static_cast<size_t>(rows)),
               nullptr, GL_STREAM_READ);
  glReadPixels(0, 0, OCCLUSION_ROW_TEXELS, rows, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();
}

Result<void> OcclusionQuery::begin(const Picture& picture, const std::vector<Item>& items,
                                   int min_px, GLuint frame_binding) {
  if (fence_) glDeleteSync(fence_);
  fence_ = nullptr;
  results_.clear();
  min_px_ = std::clamp(min_px, 0, OCCLUSION_MAX_PX);
  if (auto ok = link(picture.orthographic, frame_binding); !ok) return ok;
  const size_t tested = std::min(items.size(), kMaxItems);
  for (size_t i = 0; i < items.size(); ++i) {
    const RegionMask visible = i < tested ? RegionMask{} : items[i].regions;
    results_.push_back({items[i].handle, items[i].regions, visible});
  }
  const auto rows = static_cast<GLsizei>(std::max<size_t>(tested, 1));
  glActiveTexture(GL_TEXTURE0);
  if (auto ok = prepare_counts(rows); !ok) return ok;
  glBindFramebuffer(GL_FRAMEBUFFER, counts_.framebuffer());
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glViewport(0, 0, counts_.width(), counts_.height());
  const float zero[4] = {0, 0, 0, 0};
  glClearBufferfv(GL_COLOR, 0, zero);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  bind_picture(picture);
  draw_items(items, tested);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE0);
  glDisable(GL_BLEND);
  start_reading(rows);
  return {};
}

std::optional<std::vector<ChunkVisibility>> OcclusionQuery::take() {
  if (!fence_) return std::nullopt;
  const GLenum state = glClientWaitSync(fence_, 0, 0);
  if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED) return std::nullopt;
  glDeleteSync(fence_);
  fence_ = nullptr;
  std::vector<uint8_t> counts(std::min(results_.size(), kMaxItems) * kRowBytes);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, read_buffer_);
  read_pack_buffer(counts);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  const int min_count = std::max(min_px_, 1);
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] < min_count) continue;
    const auto bit = static_cast<int32_t>(i % kRowBytes);
    results_[i / kRowBytes].visible.insert({bit % 8, bit / 8 % 8, bit / 64});
  }
  return std::move(results_);
}

void OcclusionQuery::release() {
  if (fence_) glDeleteSync(fence_);
  counts_.release();
  if (read_buffer_) glDeleteBuffers(1, &read_buffer_);
  program_ = GlProgram{};
  abandon();
}

void OcclusionQuery::abandon() {
  program_.abandon();
  counts_.abandon();
  read_buffer_ = 0;
  fence_ = nullptr;
  results_.clear();
}

}  // namespace isosplat::render
