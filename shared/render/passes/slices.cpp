#include "shared/render/passes/slices.h"

#include <algorithm>

#include "shared/render/passes/image_triangle.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

void set_vector(const GlProgram& program, const char* name, Vec3d v) {
  glUniform3f(program.uniform(name), static_cast<float>(v.x), static_cast<float>(v.y),
              static_cast<float>(v.z));
}

/// The depth offset that draws the pattern in front of the caps of all isosurfaces.
float nearer_than_caps(const RenderSettings& settings) {
  const auto caps = settings.clip_caps ? static_cast<float>(kMaxIsosurfaces) : 0.0f;
  return static_cast<float>(CAP_DEPTH_STEP) * caps + static_cast<float>(SLICE_DEPTH_STEP);
}

/// The uniforms of shaders/slice.glsl.
void set_plane(const GlProgram& program, const Frame& frame, const Plane& plane, float nearer) {
  glUniform1f(program.uniform("u_slice_nearer"), nearer);
  glUniform4f(program.uniform("u_slice"), static_cast<float>(plane.normal.x),
              static_cast<float>(plane.normal.y), static_cast<float>(plane.normal.z),
              static_cast<float>(plane.offset));
  set_vector(program, "u_volume_low", frame.volume_low());
  set_vector(program, "u_volume_high", frame.volume_high());
}

/// The slope and intercept that map a quantized value to a position in the colour map.
std::array<float, 2> scalar_of(const RenderSettings& settings, const ValueMapping& mapping) {
  const bool is_mapped = settings.colour_by == ColourBy::isovalue;
  const double low = is_mapped ? settings.colour_low : settings.slice_low;
  const double range = (is_mapped ? settings.colour_high : settings.slice_high) - low;
  const double per_value = range != 0 ? 1 / range : 0;
  return {static_cast<float>(mapping.scale * per_value),
          static_cast<float>((mapping.offset - low) * per_value)};
}

}  // namespace

Result<void> Slices::draw(const DrawContext& context, const Frame& frame, const ChunkStore& chunks,
                          const ValueMapping& mapping) {
  glBindFramebuffer(GL_FRAMEBUFFER, context.targets.layer_framebuffer(0));
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);  // finer cells replace coarser ones at the same depth
  Result<void> done;
  for (const Plane& plane : frame.slices()) {
    done = draw_pattern(context, frame, plane);
    if (done) done = draw_cells(context, frame, chunks, mapping, plane);
    if (!done) break;
  }
  glDepthFunc(GL_LESS);
  return done;
}

Result<void> Slices::draw_pattern(const DrawContext& context, const Frame& frame,
                                  const Plane& plane) {
  const auto linked = context.programs.image(ImagePass::slice);
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  glViewport(0, 0, context.targets.width(), context.targets.height());
  glUseProgram(program.name());
  set_plane(program, frame, plane, nearer_than_caps(context.settings));
  // Lines grow with the image: 1 px up to a height of 700 px.
  glUniform1f(program.uniform("u_line_px"),
              std::max(1.0f, static_cast<float>(context.image_height) / 700));
  draw_image_triangle(context);
  return {};
}

Result<void> Slices::draw_cells(const DrawContext& context, const Frame& frame,
                                const ChunkStore& chunks, const ValueMapping& mapping,
                                const Plane& plane) {
  const int width = context.targets.width(), height = context.targets.height();
  const auto guard = static_cast<GLint>(context.limits.guard_px);
  const auto scalar = scalar_of(context.settings, mapping);
  const ShaderPrograms::Splat* used = nullptr;
  // Unbinds the depths of an earlier pass: the program does not read them, but they may have
  // another type than its sampler.
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, 0);
  draw_list_.collect_cut(chunks, frame, plane);
  for (const DrawItem& item : draw_list_.items()) {
    const SampleRange& range = item.chunk->range;
    const bool pulled = item.largest_px > context.limits.offered.max_point_size;
    const auto program = context.programs.splat({SplatPass::slice_cells, pulled});
    if (!program) return tl::unexpected(program.error());
    if (*program != used) {
      used = *program;
      glUseProgram(used->program.name());
      set_plane(used->program, frame, plane,
                nearer_than_caps(context.settings) + static_cast<float>(SLICE_DEPTH_STEP));
      glUniform2fv(used->program.uniform("u_slice_scalar"), 1, scalar.data());
      glUniform1i(used->drops_hidden, 0);
      if (pulled) {
        glViewport(0, 0, width, height);
      } else {
        glViewport(-guard, -guard, width + 2 * guard, height + 2 * guard);
      }
    }
    glUniform4fv(used->block, 1, item.block.data());
    if (pulled) {
      sample_texture_.load(chunks.buffers(), range);
      glBindVertexArray(context.empty_vertex_array);
    } else {
      glBindVertexArray(chunks.buffers().vertex_array(range.buffer));
    }
    draw_list_.for_each_range(item, ClusterSubset::all, [&](uint32_t first, uint32_t count) {
      if (pulled) {
        runs_.add(6 * first, 6 * count);  // two triangles per sample
      } else {
        runs_.add(range.first + first, count);
      }
    });
    context.statistics.draw_calls +=
        runs_.draw(pulled ? GL_TRIANGLES : GL_POINTS, context.limits.multi_draw);
  }
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

void Slices::abandon() {
  draw_list_.clear();
  sample_texture_.abandon();
}

}  // namespace isosplat::render
