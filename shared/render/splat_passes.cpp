#include <algorithm>
#include <cmath>

#include "shared/render/renderer_state.h"
#include "shared/render/shader_constants.h"

namespace isosplat {
namespace {

/// Where the CPU rasterises: threads are at it while this one shades the next vertices.
constexpr uint32_t kSamplesPerFlush = 1u << 14;

void write_colours(bool write) {
  const GLboolean mask = write ? GL_TRUE : GL_FALSE;
  glColorMask(mask, mask, mask, mask);
}

}  // namespace

/// Visible chunks inside the frustum and the clip planes, the nearest first.
void Renderer::State::collect_items(const Frame& frame) {
  items.clear();
  const auto& lens = frame.block().lens;
  for (const auto& [handle, regions] : visible) {
    const auto found = chunks.find(handle);
    if (found == chunks.end() || found->second.range.count == 0) continue;
    const Chunk& chunk = found->second;
    const Frame::Box box = frame.box(chunk.low, chunk.high);
    if (!frame.may_see(box)) {
      ++statistics.chunks_culled;
      continue;
    }
    const double level_scale = std::ldexp(1.0, static_cast<int>(chunk.block.level));
    const double nearest = frame.nearest(box);
    const double diagonal = 2 * level_scale * double(frame.block().cell[3]);
    // Oblique cells near the image's corners look larger than their diagonal.
    const double largest_px = 1.5 * diagonal * double(lens[0]) * double(lens[3]) /
                              std::max(nearest - diagonal, double(frame.block().depth[2]));
    const Vec3d corner = box.centre - box.half;
    items.push_back({handle,
                     &chunk,
                     nearest,
                     {static_cast<float>(corner.x), static_cast<float>(corner.y),
                      static_cast<float>(corner.z), static_cast<float>(level_scale)},
                     regions,
                     static_cast<float>(largest_px),
                     0});
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

/// The box of a cluster's cells, in frame space.
Occluders::Box Renderer::State::cluster_box(const Frame& frame, const DrawItem& item,
                                            const SampleCluster& cluster) {
  const auto& s = frame.block().cell;
  const auto& [x, y, z, scale] = item.block;
  const Vec3f size = Vec3f{s[0], s[1], s[2]} * scale;
  const auto along = [](uint8_t low, uint8_t high, float from, float cell) {
    return std::pair{from + 0.5f * cell * static_cast<float>(low + high),
                     0.5f * cell * static_cast<float>(high - low)};
  };
  const auto [cx, hx] = along(cluster.low.x, cluster.high.x, x, size.x);
  const auto [cy, hy] = along(cluster.low.y, cluster.high.y, y, size.y);
  const auto [cz, hz] = along(cluster.low.z, cluster.high.z, z, size.z);
  return {{cx, cy, cz}, {hx, hy, hz}};
}

/// Finds out which clusters have a part of the isosurface in the image, and which of them are
/// likely to be seen. Answers how many samples are not.
uint64_t Renderer::State::estimate_visibility(const Frame& frame, float quantized_isovalue) {
  occluders.begin(frame.block());
  visibilities.clear();
  const auto side = static_cast<float>(frame.cell_side());
  for (DrawItem& item : items) {
    item.first_visibility = static_cast<uint32_t>(visibilities.size());
    const float cell = item.block[3] * side;
    for (const SampleCluster& cluster : item.chunk->clusters) {
      const bool drawn = is_active(cluster.interval, quantized_isovalue) &&
                         item.regions.contains(cluster.region_index());
      const auto box = cluster_box(frame, item, cluster);
      const bool seen = drawn && occluders.is_in_image(box, item.largest_px);
      visibilities.push_back(seen ? ExpectedVisibility::likely : ExpectedVisibility::none);
      if (seen)
        occluders.add(box, float(OCCLUDER_FILL) * static_cast<float>(cluster.count) * cell * cell);
    }
  }
  uint64_t unlikely = 0;
  for (const DrawItem& item : items) {
    for (size_t i = 0; i < item.chunk->clusters.size(); ++i) {
      ExpectedVisibility& visibility = visibilities[item.first_visibility + i];
      if (visibility == ExpectedVisibility::likely &&
          occluders.hide(cluster_box(frame, item, item.chunk->clusters[i]))) {
        visibility = ExpectedVisibility::unlikely;
        unlikely += item.chunk->clusters[i].count;
      }
    }
  }
  return unlikely;
}

/// Calls draw(first, count) for runs of the chunk's samples, those of neighbours at once.
template <typename Draw>
void Renderer::State::for_each_run(const DrawItem& item, Share share, Draw draw) const {
  uint32_t first = 0, count = 0;
  const auto& clusters = item.chunk->clusters;
  for (size_t i = 0; i < clusters.size(); ++i) {
    const ExpectedVisibility visibility = visibilities[item.first_visibility + i];
    const bool drawn = share == Share::likely_seen ? visibility == ExpectedVisibility::likely
                       : share == Share::not_hidden_of_rest
                           ? visibility == ExpectedVisibility::unlikely
                           : visibility != ExpectedVisibility::none;
    if (drawn && count > 0 && clusters[i].first == first + count) {
      count += clusters[i].count;
    } else if (drawn) {
      if (count > 0) draw(first, count);
      first = clusters[i].first;
      count = clusters[i].count;
    }
  }
  if (count > 0) draw(first, count);
}

/// Draws a share of the splats into the target that is bound.
Result<void> Renderer::State::draw_splats(Pass pass, const Frame& frame, int isosurface,
                                          Share share) {
  const Isosurface& surface = settings.isosurfaces[static_cast<size_t>(isosurface)];
  const float quantized_isovalue = mapping.quantized_isovalue(surface.isovalue);
  const int width = targets.width(), height = targets.height();
  // Points whose centres are outside of the image are not drawn, however large: so the viewport is
  // larger than the image.
  const auto guard = static_cast<GLint>(limits.guard_px);
  const bool drops_hidden = share == Share::not_hidden_of_rest || share == Share::not_hidden;
  const SplatProgram* current = nullptr;
  uint32_t level = ~0u, buffer = ~0u, samples_waiting = 0;
  write_colours(pass != pass_visibility);
  for (const DrawItem& item : items) {
    const Chunk& chunk = *item.chunk;
    if (!is_active(chunk.interval, quantized_isovalue)) continue;
    const bool pulled = item.largest_px > limits.offered.max_point_size;
    const bool large = settings.projected && item.largest_px > float(LARGE_SPLAT_PX) &&
                       (pass == pass_quad || pass == pass_ellipse);
    const Pass chosen = large ? pass_exact : pass;
    // The few that are large are not culled, but all drawn at once.
    if ((pulled || large) && share == Share::not_hidden_of_rest) continue;
    const auto program = splat_program(chosen, pulled, frame.clipped());
    if (!program) {
      write_colours(true);
      return tl::unexpected(program.error());
    }
    if (*program != current) {
      current = *program;
      glUseProgram(current->program.name());
      glUniform1f(current->quantized_isovalue, quantized_isovalue);
      glUniform1ui(current->isosurface, static_cast<GLuint>(isosurface));
      glUniform1i(current->drops_hidden, drops_hidden && !large);
      if (lit) set_light(current->program);
      level = buffer = ~0u;
      if (pulled) {
        glViewport(0, 0, width, height);
        glBindVertexArray(empty_vertex_array);
      } else {
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
    const SampleRange& range = chunk.range;
    if (pulled) {
      load_samples(range);
    } else if (range.buffer != buffer) {
      buffer = range.buffer;
      glBindVertexArray(buffers.vertex_array(buffer));
    }
    uint32_t samples = 0;
    for_each_run(item, pulled || large ? Share::all : share, [&](uint32_t first, uint32_t count) {
      if (pulled)
        runs.add(6 * first, 6 * count);
      else
        runs.add(range.first + first, count);
      samples += count;
    });
    statistics.draw_calls += runs.draw(pulled ? GL_TRIANGLES : GL_POINTS, limits.multi_draw);
    if (share != Share::not_hidden) statistics.samples_drawn += samples;
    samples_waiting += samples;
    if (limits.on_cpu && samples_waiting > kSamplesPerFlush) {
      glFlush();
      samples_waiting = 0;
    }
    if (share == Share::all || share == Share::likely_seen) ++statistics.chunks_drawn;
  }
  write_colours(true);
  return {};
}

/// Draws into the target: first what is likely to be seen, then what of the rest that does not hide
/// (U. Haar, S. Aaltonen, "GPU-driven rendering pipelines", SIGGRAPH 2015 course: two-pass
/// occlusion culling).
Result<void> Renderer::State::draw_culled(Pass pass, const Frame& frame, int isosurface,
                                          const SplatTarget& target) {
  const uint64_t unlikely = estimate_visibility(
      frame,
      mapping.quantized_isovalue(settings.isosurfaces[static_cast<size_t>(isosurface)].isovalue));
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  // Taking depths costs as much as drawing some samples, by the size of the image.
  const auto pixels = uint64_t(targets.width()) * uint64_t(targets.height());
  if (unlikely < pixels / 64) return draw_splats(pass, frame, isosurface, Share::all);
  if (auto ok = draw_splats(pass, frame, isosurface, Share::likely_seen); !ok) return ok;
  take_depths(pass, target);
  return draw_splats(pass, frame, isosurface, Share::not_hidden_of_rest);
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
  const auto accumulated = draw_splats(pass_accumulate, frame, isosurface, Share::not_hidden);
  // Also where it failed: what is drawn next sets neither.
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  if (!accumulated) return accumulated;

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
