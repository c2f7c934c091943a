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

/// Draws the splats that `culling` (CULL_*) leaves, into the target that is bound.
Result<void> Renderer::State::draw_splats(Pass pass, const Frame& frame, int isosurface,
                                          int culling) {
  const Isosurface& surface = settings.isosurfaces[static_cast<size_t>(isosurface)];
  const float isocode = mapping.isocode(surface.isovalue);
  const int width = targets.width(), height = targets.height();
  // Points whose centres are outside of the image are not drawn, however large: so the viewport is
  // larger than the image.
  const auto guard = static_cast<GLint>(limits.guard_px);
  const bool counts = pass != pass_occluders && (culling == CULL_NONE || culling == CULL_LIKELY);
  const SplatProgram* current = nullptr;
  uint32_t level = ~0u, buffer = ~0u;
  write_colours(pass != pass_visibility);
  glActiveTexture(GL_TEXTURE2);
  glBindTexture(GL_TEXTURE_2D, pass == pass_occluders ? 0 : occluders.texture());
  for (const DrawItem& item : items) {
    const Chunk& chunk = *item.chunk;
    if (!is_active(chunk.interval, isocode)) continue;
    const bool pulled = item.largest_px > limits.offered.max_point_size;
    const bool large = settings.projected && item.largest_px > float(LARGE_SPLAT_PX) &&
                       (pass == pass_quad || pass == pass_ellipse);
    const Pass chosen = large ? pass_exact : pass;
    // The few that are large are not culled, but all drawn at once.
    if ((pulled || large) && culling == CULL_REST) continue;
    if (pulled && pass == pass_occluders) continue;
    const auto program = splat_program(chosen, pulled, frame.clipped());
    if (!program) return tl::unexpected(program.error());
    if (*program != current) {
      current = *program;
      glUseProgram(current->program.name());
      glUniform1f(current->isocode, isocode);
      glUniform1ui(current->isosurface, static_cast<GLuint>(isosurface));
      glUniform1i(current->culling, large ? CULL_NONE : culling);
      if (lit) set_light(current->program);
      level = buffer = ~0u;
      if (pulled) {
        glViewport(0, 0, width, height);
        glBindVertexArray(empty_vertex_array);
      } else if (pass != pass_occluders) {
        glViewport(-guard, -guard, width + 2 * guard, height + 2 * guard);
        glActiveTexture(GL_TEXTURE1);
        glBindTexture(GL_TEXTURE_2D,
                      chosen == pass_quad ? drawn_depths.texture() : depth_tiles.texture());
      }
    }
    if (chunk.block.level != level) {
      level = chunk.block.level;
      glUniform3fv(current->scalar, 1, scalar_weights(frame, surface, level).data());
    }
    glUniform4fv(current->block, 1, item.block.data());
    glUniform4uiv(current->regions, 4, item.regions.words().data());
    const SampleRange& range = chunk.range;
    const auto count = static_cast<GLsizei>(range.count);
    if (pulled) {
      load_samples(range);
      glDrawArrays(GL_TRIANGLES, 0, 6 * count);
    } else if (pass == pass_occluders) {
      const uint32_t from = (range.first + OCCLUDER_STRIDE - 1) / OCCLUDER_STRIDE;
      const uint32_t to = (range.first + range.count + OCCLUDER_STRIDE - 1) / OCCLUDER_STRIDE;
      glBindVertexArray(buffers.sparse_vertex_array(range.buffer));
      glDrawArrays(GL_POINTS, static_cast<GLint>(from), static_cast<GLsizei>(to - from));
    } else {
      if (range.buffer != buffer) {
        buffer = range.buffer;
        glBindVertexArray(buffers.vertex_array(buffer));
      }
      glDrawArrays(GL_POINTS, static_cast<GLint>(range.first), count);
    }
    ++statistics.draw_calls;
    if (counts) {
      statistics.samples_drawn += range.count;
      ++statistics.chunks_drawn;
    }
  }
  write_colours(true);
  return {};
}

/// Draws into the target: first what is likely to be seen, then what of the rest that does not hide
/// (U. Haar, S. Aaltonen, "GPU-driven rendering pipelines", SIGGRAPH 2015 course: two-pass
/// occlusion culling).
Result<void> Renderer::State::draw_culled(Pass pass, const Frame& frame, int isosurface,
                                          const SplatTarget& target) {
  const int width = targets.width(), height = targets.height();
  const float isocode =
      mapping.isocode(settings.isosurfaces[static_cast<size_t>(isosurface)].isovalue);
  uint64_t samples = 0;
  for (const DrawItem& item : items) {
    if (is_active(item.chunk->interval, isocode)) samples += item.chunk->range.count;
  }
  // Looking for what is hidden costs as much as drawing some samples, by the size of the image.
  if (samples < uint64_t(width) * uint64_t(height) / 16) {
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    return draw_splats(pass, frame, isosurface, CULL_NONE);
  }
  occluders.begin();
  if (auto ok = draw_splats(pass_occluders, frame, isosurface, CULL_NONE); !ok) return ok;
  occluders.take(empty_vertex_array);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  if (auto ok = draw_splats(pass, frame, isosurface, CULL_LIKELY); !ok) return ok;
  take_depths(pass, target);
  return draw_splats(pass, frame, isosurface, CULL_REST);
}

/// Takes what this pass's splats look up to learn whether they are hidden.
void Renderer::State::take_depths(Pass pass, const SplatTarget& target) {
  if (pass == pass_quad) {
    drawn_depths.take(target);
  } else {
    depth_tiles.take(target, empty_vertex_array);
  }
}

Result<void> Renderer::State::draw_isosurface(SplatKind kind, const Frame& frame, int isosurface,
                                              int layer) {
  const int width = targets.width(), height = targets.height();
  if (auto ok = occluders.prepare(width, height); !ok) return ok;
  if (auto ok = depth_tiles.prepare(width, height); !ok) return ok;
  if (kind == SplatKind::quad) {
    if (auto ok = drawn_depths.prepare(width, height); !ok) return ok;
  }
  if (kind != SplatKind::blended) {
    return draw_culled(kind == SplatKind::quad      ? pass_quad
                       : kind == SplatKind::ellipse ? pass_ellipse
                                                    : pass_exact,
                       frame, isosurface, lit ? targets.picture() : targets.layer(layer));
  }
  const float zero[4] = {0, 0, 0, 0}, one = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sums().framebuffer);
  glClearBufferfv(GL_COLOR, 0, zero);
  glClearBufferfv(GL_COLOR, 1, zero);
  glClearBufferfv(GL_DEPTH, 0, &one);
  if (auto ok = draw_culled(pass_visibility, frame, isosurface, targets.sums()); !ok) return ok;
  depth_tiles.take(targets.sums(), empty_vertex_array);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glBlendEquationSeparate(GL_FUNC_ADD, GL_MAX);
  if (auto ok = draw_splats(pass_accumulate, frame, isosurface, CULL_HIDDEN); !ok) return ok;
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
  const auto linked = image_program(lit ? pass_lit_mesh : pass_mesh);
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  glBindFramebuffer(GL_FRAMEBUFFER,
                    lit ? targets.picture().framebuffer : targets.layer_framebuffer(0));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram(program.name());
  if (lit) set_light(program);
  glUniformMatrix4fv(program.uniform("u_clip_from_world"), 1, GL_FALSE, frame.mesh_clip().data());
  glUniformMatrix3fv(program.uniform("u_view_from_world"), 1, GL_FALSE, frame.mesh_view().data());
  glBindVertexArray(mesh_vertex_array);
  glDrawElements(GL_TRIANGLES, mesh_indices, GL_UNSIGNED_INT, nullptr);
  ++statistics.draw_calls;
  return {};
}

}  // namespace isosplat
