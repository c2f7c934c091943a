#include <algorithm>
#include <cmath>

#include "shared/render/renderer_state.h"
#include "shared/render/shader_constants.h"

namespace isosplat {
namespace {

void write_colours(bool write) {
  const GLboolean mask = write ? GL_TRUE : GL_FALSE;
  glColorMask(mask, mask, mask, mask);
}

}  // namespace

/// Visible chunks inside the frustum and the clip planes, the nearest first.
void Renderer::State::collect_items(const Frame& frame) {
  items.clear();
  const auto& lens = frame.block().lens;
  for (const auto& [id, regions] : visible) {
    const auto found = chunks.find(id);
    if (found == chunks.end() || found->second.range.count == 0) continue;
    const Chunk& chunk = found->second;
    const Frame::Box box = frame.box(chunk.low, chunk.high);
    if (!frame.may_see(box)) {
      ++statistics.chunks_culled;
      continue;
    }
    const double level_scale = std::ldexp(1.0, static_cast<int>(chunk.block.level));
    const double nearest = frame.nearest(box);
    const auto& s = frame.block().spacing;
    const double diagonal = level_scale * length(Vec3d{s[0], s[1], s[2]});
    // Oblique cells near the image's corners look larger than their diagonal.
    const double largest_px = 1.5 * diagonal * double(lens[0]) * double(lens[3]) /
                              std::max(nearest - diagonal, double(frame.block().depth[2]));
    const Vec3d corner = box.centre - box.half;
    items.push_back({id,
                     &chunk,
                     nearest,
                     {static_cast<float>(corner.x), static_cast<float>(corner.y),
                      static_cast<float>(corner.z), static_cast<float>(level_scale)},
                     regions,
                     static_cast<float>(largest_px)});
  }
  std::sort(items.begin(), items.end(),
            [](const DrawItem& a, const DrawItem& b) { return a.nearest < b.nearest; });
}

std::array<float, 3> Renderer::State::scalar_weights(const Frame& frame, const Isosurface& surface,
                                                     uint32_t level) const {
  const double range = settings.colour_high - settings.colour_low;
  const double per_value = range != 0 ? 1 / range : 0;
  switch (settings.colour_by) {
    case ColourBy::isovalue:
      return {static_cast<float>((surface.isovalue - settings.colour_low) * per_value), 0, 0};
    case ColourBy::gradient:
      return {static_cast<float>(-settings.colour_low * per_value),
              static_cast<float>(mapping.scale / frame.unit() * per_value), 0};
    case ColourBy::level:
      return {static_cast<float>(level) / 7, 0, 0};
    case ColourBy::projection_error:
      return {0, 0, 2};
    case ColourBy::isosurface:
    case ColourBy::depth:
      break;
  }
  return {0, 0, 0};
}

/// Copies a chunk, on the GPU, to where vertices can be fetched by number.
void Renderer::State::load_samples(const SampleRange& range) {
  const int rows =
      static_cast<int>((range.count + SAMPLE_TEXTURE_WIDTH - 1) / SAMPLE_TEXTURE_WIDTH);
  glActiveTexture(GL_TEXTURE0);
  if (rows > sample_texture_rows) {
    if (sample_texture) glDeleteTextures(1, &sample_texture);
    sample_texture_rows = std::max(rows, 64);
    glGenTextures(1, &sample_texture);
    glBindTexture(GL_TEXTURE_2D, sample_texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, SAMPLE_TEXTURE_WIDTH, sample_texture_rows);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glBindTexture(GL_TEXTURE_2D, sample_texture);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers.buffer_name(range.buffer));
  const auto copy = [&](int y, int width, int height) {
    const size_t sample = range.first + size_t(y) * SAMPLE_TEXTURE_WIDTH;
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, y, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                    reinterpret_cast<const void*>(sample * sizeof(PackedSample)));
  };
  const int full = static_cast<int>(range.count / SAMPLE_TEXTURE_WIDTH);
  if (full) copy(0, SAMPLE_TEXTURE_WIDTH, full);
  const int rest = static_cast<int>(range.count % SAMPLE_TEXTURE_WIDTH);
  if (rest) copy(full, rest, 1);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

/// Draws into the target, which is bound. Once some of the samples are drawn, its depths tell which
/// of the rest are hidden.
Result<void> Renderer::State::draw_splats(Pass pass, const Frame& frame, int isosurface,
                                          const SplatTarget& target) {
  const Isosurface& surface = settings.isosurfaces[static_cast<size_t>(isosurface)];
  const float isocode = mapping.isocode(surface.isovalue);
  const int width = targets.width(), height = targets.height();
  // Points whose centres are outside of the image are not drawn, however large: so the viewport is
  // larger than the image.
  const auto guard = static_cast<GLint>(limits.guard_px);
  const SplatProgram* current = nullptr;
  uint32_t level = ~0u, buffer = ~0u;
  uint64_t samples = 0, drawn = 0;
  for (const DrawItem& item : items) {
    if (is_active(item.chunk->interval, isocode)) samples += item.chunk->range.count;
  }
  // A look costs as much as it takes to draw some samples, by the size of the image.
  const uint64_t least = uint64_t(width) * uint64_t(height) / 10;
  const uint64_t step = pass == pass_accumulate ? samples : std::max(samples / 4, least);
  uint64_t next_look = step;
  for (const DrawItem& item : items) {
    const Chunk& chunk = *item.chunk;
    if (!is_active(chunk.interval, isocode)) continue;
    if (drawn >= next_look) {
      write_colours(true);
      depth_tiles.take(target, empty_vertex_array);
      write_colours(pass != pass_visibility);
      next_look += step;
      current = nullptr;
    }
    drawn += chunk.range.count;
    const bool pulled = item.largest_px > limits.offered.max_point_size;
    const bool large = settings.projected && item.largest_px > float(LARGE_SPLAT_PX);
    const Pass chosen = large && (pass == pass_quad || pass == pass_ellipse) ? pass_exact : pass;
    const auto program = splat_program(chosen, pulled, frame.clipped());
    if (!program) return tl::unexpected(program.error());
    if (*program != current) {
      current = *program;
      glUseProgram(current->program.name());
      glUniform1f(current->isocode, isocode);
      glUniform1ui(current->isosurface, static_cast<GLuint>(isosurface));
      level = buffer = ~0u;
      if (pulled) {
        glViewport(0, 0, width, height);
        glBindVertexArray(empty_vertex_array);
      } else {
        glViewport(-guard, -guard, width + 2 * guard, height + 2 * guard);
        glActiveTexture(GL_TEXTURE1);
        glBindTexture(GL_TEXTURE_2D, depth_tiles.texture());
      }
    }
    if (chunk.block.level != level) {
      level = chunk.block.level;
      glUniform3fv(current->scalar, 1, scalar_weights(frame, surface, level).data());
    }
    glUniform4fv(current->block, 1, item.block.data());
    glUniform4uiv(current->regions, 4, item.regions.words().data());
    const auto count = static_cast<GLsizei>(chunk.range.count);
    if (pulled) {
      load_samples(chunk.range);
      glDrawArrays(GL_TRIANGLES, 0, 6 * count);
    } else {
      if (chunk.range.buffer != buffer) {
        buffer = chunk.range.buffer;
        glBindVertexArray(buffers.vertex_array(buffer));
      }
      glDrawArrays(GL_POINTS, static_cast<GLint>(chunk.range.first), count);
    }
    ++statistics.draw_calls;
    if (pass != pass_accumulate) {
      statistics.samples_drawn += chunk.range.count;
      ++statistics.chunks_drawn;
    }
  }
  return {};
}

Result<void> Renderer::State::draw_isosurface(SplatKind kind, const Frame& frame, int isosurface,
                                              int layer) {
  // Each surface starts from its target's depths as they are: another one's tiles hide nothing
  // here.
  if (auto ok = depth_tiles.prepare(targets.width(), targets.height()); !ok) return ok;
  if (kind != SplatKind::blended) {
    depth_tiles.take(targets.layer(layer), empty_vertex_array);
    return draw_splats(kind == SplatKind::quad      ? pass_quad
                       : kind == SplatKind::ellipse ? pass_ellipse
                                                    : pass_exact,
                       frame, isosurface, targets.layer(layer));
  }
  const float zero[4] = {0, 0, 0, 0}, one = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sums().framebuffer);
  glClearBufferfv(GL_COLOR, 0, zero);
  glClearBufferfv(GL_COLOR, 1, zero);
  glClearBufferfv(GL_DEPTH, 0, &one);
  depth_tiles.take(targets.sums(), empty_vertex_array);
  write_colours(false);
  if (auto ok = draw_splats(pass_visibility, frame, isosurface, targets.sums()); !ok) return ok;
  write_colours(true);
  depth_tiles.take(targets.sums(), empty_vertex_array);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glBlendEquationSeparate(GL_FUNC_ADD, GL_MAX);
  if (auto ok = draw_splats(pass_accumulate, frame, isosurface, targets.sums()); !ok) return ok;
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);

  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
  glViewport(0, 0, targets.width(), targets.height());
  const auto normalise = image_program(pass_normalise);
  if (!normalise) return tl::unexpected(normalise.error());
  glUseProgram((*normalise)->name());
  glUniform1ui((*normalise)->uniform("u_isosurface"), static_cast<GLuint>(isosurface));
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, targets.normal_sums());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, targets.scalar_sums());
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, 0);
  ++statistics.draw_calls;
  return {};
}

Result<void> Renderer::State::draw_mesh(const Frame& frame) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(0));
  glViewport(0, 0, targets.width(), targets.height());
  const auto program = image_program(pass_mesh);
  if (!program) return tl::unexpected(program.error());
  const GlProgram& mesh_program = **program;
  glUseProgram(mesh_program.name());
  glUniformMatrix4fv(mesh_program.uniform("u_clip_from_world"), 1, GL_FALSE,
                     frame.mesh_clip().data());
  glUniformMatrix3fv(mesh_program.uniform("u_view_from_world"), 1, GL_FALSE,
                     frame.mesh_view().data());
  glBindVertexArray(mesh_vertex_array);
  glDrawElements(GL_TRIANGLES, mesh_indices, GL_UNSIGNED_INT, nullptr);
  ++statistics.draw_calls;
  return {};
}

}  // namespace isosplat
