#include "shared/render/passes/splat_passes.h"

#include <algorithm>
#include <limits>

#include "shared/render/passes/image_passes.h"
#include "shared/render/passes/line_weights.h"
#include "shared/render/passes/scalar_weights.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

/// Where the CPU rasterises, a flush after this many samples lets its threads rasterise while this
/// thread runs the next vertex shaders.
constexpr uint32_t kSamplesPerFlush = 1u << 14;

static_assert(OCCLUDER_PX == HIDING_TILE_PX);  // for DrawList::drop_occluded

constexpr uint32_t kUnset = std::numeric_limits<uint32_t>::max();

SplatPass pass_of(SplatKind kind) {
  switch (kind) {
    case SplatKind::quad:
      return SplatPass::quad;
    case SplatKind::ellipse:
      return SplatPass::ellipse;
    case SplatKind::exact:
      break;
  }
  return SplatPass::exact;
}

}  // namespace

/// One isosurface in one pass.
struct SplatPasses::Pass {
  const DrawContext& context;
  const SplatFrame& splats;
  SplatPass pass;
  int isosurface;
  double isovalue;
  float quantized_isovalue;
  uint32_t finest_level = 0;                // of the gradients
  SmoothSizes smooth_sizes = kDrawnSmooth;  // of the gradients
  std::span<const float> reachable;         // of the cut cells
  int rank = 0;                             // of the cut cells
  float margin_px = 0;                      // of the cut cells
  bool smooth_triangles = false;

  Pass(const DrawContext& context_, const SplatFrame& splats_, SplatPass pass_, int isosurface_)
      : context(context_),
        splats(splats_),
        pass(pass_),
        isosurface(isosurface_),
        isovalue(context.settings.isosurfaces[static_cast<size_t>(isosurface)].isovalue),
        quantized_isovalue(splats.mapping.quantized_isovalue(isovalue)) {}

  /// The number of the isosurface in a program: among those of the volume for gradients, among the
  /// colours that are set where the program lights the surface, else among all.
  GLuint number_in(SplatPass variant) const {
    if (splats.lit) return 0;
    if (variant != SplatPass::gradients) return static_cast<GLuint>(isosurface);
    const auto& own = splats.isosurfaces;
    return static_cast<GLuint>(std::find(own.begin(), own.end(), isosurface) - own.begin());
  }
};

/// The objects that are bound while the items of a pass are drawn. It avoids redundant GL calls.
struct SplatPasses::BoundState {
  const ShaderPrograms::Splat* program = nullptr;
  uint32_t level = kUnset, buffer = kUnset;
  uint32_t unflushed_samples = 0;
};

void SplatPasses::use_program(const Pass& pass, SplatPass variant, bool pulled, bool drops_hidden,
                              const ShaderPrograms::Splat& program) {
  const DrawContext& context = pass.context;
  const int width = context.targets.width(), height = context.targets.height();
  glUseProgram(program.program.name());
  glUniform1f(program.quantized_isovalue, pass.quantized_isovalue);
  glUniform1ui(program.isosurface, pass.number_in(variant));
  glUniform1i(program.drops_hidden, drops_hidden);
  if (program.field >= 0) {
    const auto weights = field_weights(context.settings, *pass.splats.field);
    glUniform3fv(program.field, 1, weights.data());
    glUniform1f(program.field_missing, least_missing(*pass.splats.field));
    if (program.lines >= 0) {
      const auto [lines, tones] = line_weights(context.settings, *pass.splats.field);
      glUniform4fv(program.lines, 1, lines.data());
      glUniform3fv(program.line_tones, 1, tones.data());
    }
  }
  if (variant == SplatPass::gradients) {
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, smooth_normals_.positions());
  }
  if (variant == SplatPass::cut_cells) {
    const auto count = static_cast<GLsizei>(pass.reachable.size());
    glUniform1fv(program.program.uniform("u_reachable"), count, pass.reachable.data());
    glUniform1i(program.program.uniform("u_reachable_count"), count);
    glUniform1i(program.program.uniform("u_rank"), pass.rank);
    glUniform1f(program.program.uniform("u_margin_px"), pass.margin_px);
  }
  if (pass.splats.lit) {
    const auto& surface = context.settings.isosurfaces[static_cast<size_t>(pass.isosurface)];
    context.lighting.apply(program.program, context.settings, {&surface, 1});
  }
  if (variant == SplatPass::triangles) triangle_cases_.bind(GL_TEXTURE2);
  if (pulled) {
    glViewport(0, 0, width, height);
    glBindVertexArray(context.empty_vertex_array);
  } else {
    const auto guard = static_cast<GLint>(context.limits.guard_px);
    glViewport(-guard, -guard, width + 2 * guard, height + 2 * guard);
  }
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D,
                variant == SplatPass::quad ? drawn_depths_.texture() : depth_tiles_.texture());
}

Result<void> SplatPasses::draw_item(const Pass& pass, ClusterSubset subset, const DrawItem& item,
                                    BoundState& bound) {
  const DrawContext& context = pass.context;
  const ChunkStore::Chunk& chunk = *item.chunk;
  const bool is_gradients = pass.pass == SplatPass::gradients;
  const float largest_px = is_gradients ? item.largest_support_px : item.largest_px;
  const bool triangles =
      pass.pass == SplatPass::quad && is_drawn_as_triangles(item, context.settings);
  const bool pulled = triangles || largest_px > context.limits.offered.max_point_size;
  const bool large = !triangles && context.settings.projected &&
                     largest_px > float(LARGE_SPLAT_PX) &&
                     (pass.pass == SplatPass::quad || pass.pass == SplatPass::ellipse);
  // Those of the squares' pass are few: they are not culled, but drawn with the first subset.
  const bool culled = pass.pass != SplatPass::quad || triangles || !(pulled || large);
  if (!culled && subset == ClusterSubset::likely_occluded) return {};
  const SplatPass variant = triangles ? SplatPass::triangles : large ? SplatPass::exact : pass.pass;
  const bool is_surface = !is_gradients && pass.pass != SplatPass::cut_cells;
  const bool clipped = pass.splats.frame.clipped() && is_surface;
  const bool smooth = triangles && pass.smooth_triangles;
  const bool field = is_surface && pass.splats.field && chunk.has_field;
  const FieldStyle style = field ? context.field_style : FieldStyle::none;
  const auto program =
      context.programs.splat({variant, pulled, clipped, pass.splats.lit, smooth, style});
  if (!program) return tl::unexpected(program.error());
  if (*program != bound.program) {
    const bool depth_tested = subset == ClusterSubset::likely_occluded || is_gradients;
    use_program(pass, variant, pulled, depth_tested && culled, **program);
    bound.program = *program;
    bound.level = bound.buffer = kUnset;
  }
  if (chunk.block.level != bound.level) {
    bound.level = chunk.block.level;
    if (is_gradients) set_support(pass, bound);
    const auto weights = scalar_weights(context.settings, pass.splats.mapping,
                                        pass.splats.frame.unit(), pass.isovalue, bound.level);
    glUniform3fv(bound.program->scalar, 1, weights.data());
  }
  glUniform4fv(bound.program->block, 1, item.block.data());
  if (smooth) gradient_lattice_.set_block(bound.program->program, pass.isosurface, chunk.block);
  const SampleRange& range = chunk.range;
  uint32_t samples = 0;
  const uint32_t vertices = triangles ? TRIANGLE_SLOTS : 6;  // 6: two triangles per sample
  const auto add_range = [&](uint32_t first, uint32_t count) {
    if (pulled) {
      runs_.add(vertices * first, vertices * count);
    } else {
      runs_.add(range.first + first, count);
    }
    samples += count;
  };
  pass.splats.list.for_each_range(item, culled ? subset : ClusterSubset::all, add_range);
  if (pulled && samples > 0) {
    if (field) field_texture_.load_field(pass.splats.chunks.buffers(), range);
    sample_texture_.load(pass.splats.chunks.buffers(), range);
  } else if (!pulled && range.buffer != bound.buffer) {
    bound.buffer = range.buffer;
    glBindVertexArray(pass.splats.chunks.buffers().vertex_array(range.buffer));
  }
  FrameStatistics& statistics = context.statistics;
  const GLenum mode = triangles ? GL_TRIANGLE_STRIP : pulled ? GL_TRIANGLES : GL_POINTS;
  statistics.draw_calls += runs_.draw(mode, context.limits.multi_draw);
  if (is_surface) {
    statistics.samples_drawn += samples;
    if (subset != ClusterSubset::likely_occluded) ++statistics.chunks_drawn;
  }
  bound.unflushed_samples += samples;
  if (context.limits.on_cpu && bound.unflushed_samples > kSamplesPerFlush) {
    glFlush();
    bound.unflushed_samples = 0;
  }
  return {};
}

/// Draws a subset of the clusters into the bound framebuffer.
Result<void> SplatPasses::draw_subset(const Pass& pass, ClusterSubset subset) {
  BoundState bound;
  Result<void> drawn;
  for (const DrawItem& item : pass.splats.list.items()) {
    if (!is_active(item.chunk->interval, pass.quantized_isovalue)) continue;
    if (pass.pass == SplatPass::gradients &&
        !has_smooth_normals(item, pass.finest_level, pass.smooth_sizes)) {
      continue;
    }
    drawn = draw_item(pass, subset, item, bound);
    if (!drawn) break;
  }
  return drawn;
}

/// Draws the clusters that are likely to be visible, and then, of the others, the samples that are
/// not occluded (U. Haar, S. Aaltonen, "GPU-driven rendering pipelines", SIGGRAPH 2015 course:
/// two-pass occlusion culling).
Result<void> SplatPasses::draw_with_occlusion_culling(const Pass& pass, const SplatTarget& target) {
  const uint64_t occluded_samples =
      pass.splats.list.estimate_visibility(pass.splats.frame, pass.quantized_isovalue);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  // Reading the depths costs as much as drawing this many samples.
  const SurfaceTargets& targets = pass.context.targets;
  const auto pixels = uint64_t(targets.width()) * uint64_t(targets.height());
  if (occluded_samples < pixels / 64) return draw_subset(pass, ClusterSubset::all);
  if (auto ok = draw_subset(pass, ClusterSubset::likely_visible); !ok) return ok;
  const auto& items = pass.splats.list.items();
  const bool squares = pass.pass == SplatPass::quad;
  const auto has_tiles = [&](const DrawItem& item) {
    return !squares || is_drawn_as_triangles(item, pass.context.settings);
  };
  const auto with_tiles = std::count_if(items.begin(), items.end(), has_tiles);
  if (with_tiles < std::ssize(items)) drawn_depths_.copy_from(target);
  if (with_tiles > 0) depth_tiles_.update(target, pass.context.empty_vertex_array);
  const auto is_close = [](const DrawItem& item) {
    return item.largest_side_px > float(TRIANGLE_SIDE_PX);
  };
  if (with_tiles > 0 && pass.context.limits.on_cpu &&
      std::any_of(items.begin(), items.end(), is_close)) {
    // The vertex shaders would wait for the depths as well.
    pass.splats.list.drop_occluded(pass.splats.frame, depth_tiles_.read_farthest());
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  }
  return draw_subset(pass, ClusterSubset::likely_occluded);
}

Result<void> SplatPasses::draw_isosurface(const DrawContext& context, const SplatFrame& splats,
                                          int isosurface, int layer) {
  const SurfaceTargets& targets = context.targets;
  const int width = targets.width(), height = targets.height();
  if (auto ok = depth_tiles_.prepare(width, height); !ok) return ok;
  if (splats.kind == SplatKind::quad) {
    if (auto ok = drawn_depths_.prepare(width, height); !ok) return ok;
  }
  Pass pass(context, splats, pass_of(splats.kind), isosurface);
  if (splats.kind == SplatKind::quad && context.settings.shading == Shading::smooth) {
    const GradientLattice::Source source{splats.frame, splats.list, splats.chunks, splats.mapping};
    const auto prepared =
        gradient_lattice_.prepare_triangles(context, source, isosurface, sample_texture_);
    if (!prepared) return tl::unexpected(prepared.error());
    pass.smooth_triangles = *prepared;
  }
  return draw_with_occlusion_culling(pass, splats.lit ? targets.picture() : targets.layer(layer));
}

Result<void> SplatPasses::draw_cut_cells(const DrawContext& context, const SplatFrame& splats,
                                         int isosurface, std::span<const float> reachable, int rank,
                                         float margin_px) {
  Pass pass(context, splats, SplatPass::cut_cells, isosurface);
  pass.reachable = reachable;
  pass.rank = rank;
  pass.margin_px = margin_px;
  splats.list.find_cut(splats.frame, pass.quantized_isovalue);
  return draw_subset(pass, ClusterSubset::all);
}

Result<void> SplatPasses::smooth_normals(const DrawContext& context, const SplatFrame& splats,
                                         std::span<const int> isosurfaces, int layer,
                                         SmoothSizes sizes) {
  const auto& items = splats.list.items();
  const uint32_t finest_level = splats.list.finest_level();
  if (std::none_of(items.begin(), items.end(), [&](const DrawItem& item) {
        return has_smooth_normals(item, finest_level, sizes);
      })) {
    return {};
  }
  const GradientLattice::Source source{splats.frame, splats.list, splats.chunks, splats.mapping};
  const auto others = gradient_lattice_.replace_normals(context, source, isosurfaces, layer, sizes,
                                                        sample_texture_);
  if (!others) return tl::unexpected(others.error());
  return others->empty() ? Result<void>() : sum_in_image(context, splats, *others, layer, sizes);
}

/// Sums the gradients around each pixel (README.md, decision 22).
Result<void> SplatPasses::sum_in_image(const DrawContext& context, const SplatFrame& splats,
                                       std::span<const int> isosurfaces, int layer,
                                       SmoothSizes sizes) {
  const SurfaceTargets& targets = context.targets;
  const int width = targets.width(), height = targets.height();
  if (auto ok = depth_tiles_.prepare(width, height); !ok) return ok;
  const bool float_blend = context.limits.offered.float_blend;
  if (auto ok = smooth_normals_.prepare(width, height, float_blend); !ok) return ok;
  depth_tiles_.update(targets.layer(layer), context.empty_vertex_array);
  if (auto ok = smooth_normals_.begin(context, layer, splats.isosurfaces); !ok) return ok;
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  const auto drawn = draw_gradients(context, splats, isosurfaces, sizes);
  // Reset the state after a failure as well: the next pass relies on it.
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glActiveTexture(GL_TEXTURE2);
  glBindTexture(GL_TEXTURE_2D, 0);
  const auto finished = smooth_normals_.finish(context, layer);
  return drawn ? finished : drawn;
}

Result<void> SplatPasses::draw_gradients(const DrawContext& context, const SplatFrame& splats,
                                         std::span<const int> isosurfaces, SmoothSizes sizes) {
  splats.list.find_contributors(splats.frame);
  for (const int isosurface : isosurfaces) {
    Pass pass(context, splats, SplatPass::gradients, isosurface);
    pass.finest_level = splats.list.finest_level();
    pass.smooth_sizes = sizes;
    if (auto ok = draw_subset(pass, ClusterSubset::all); !ok) return ok;
  }
  return {};
}

/// Sets the uniforms of gradients that depend on the level. A cell's weight is proportional to the
/// inverse of its volume: where levels meet, coarse cells then change normals within about one fine
/// cell. Whether a cell contributes depends on the size of the finest cells at its position: an
/// occluded coarse cell must not determine the normals of visible cells that are too small to
/// contribute. Sums stay below 65504, the largest 16-bit float: at most eight gradients of 65535
/// quantized values per unit.
void SplatPasses::set_support(const Pass& pass, const BoundState& bound) {
  const Frame& frame = pass.splats.frame;
  const FrameBlock& block = frame.block();
  const auto level = static_cast<int>(bound.level);
  const int coarser = level - static_cast<int>(pass.finest_level);
  const auto cells = static_cast<float>(std::ldexp(1.0, level));
  const auto finest = static_cast<int>(pass.finest_level);
  const double weight = std::ldexp(1.0 / 16, finest - 3 * coarser);
  const double finest_side = std::ldexp(frame.cell_side(), finest);
  const auto [from_px, full_px] = pass.smooth_sizes;
  glUniform1f(bound.program->gradient_weight, static_cast<float>(weight));
  glUniform1f(bound.program->finest_side_px, static_cast<float>(finest_side) * block.focal_px);
  glUniform2f(bound.program->smooth_px, from_px, 1 / (full_px - from_px));
  const auto& edges = block.cell_edges;
  glUniform3f(bound.program->per_cell, 1 / (edges[0] * cells), 1 / (edges[1] * cells),
              1 / (edges[2] * cells));
}

Result<void> SplatPasses::warm_up(const DrawContext& context, const SampleBuffers& buffers,
                                  const SampleRange& inactive_sample) {
  if (auto ok = depth_tiles_.prepare(1, 1); !ok) return ok;
  depth_tiles_.update(context.targets.layer(0), context.empty_vertex_array);
  for (const SplatPass pass : {SplatPass::exact, SplatPass::ellipse}) {
    const auto splat = context.programs.splat({pass});
    if (!splat) return tl::unexpected(splat.error());
    glUseProgram((*splat)->program.name());
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, depth_tiles_.texture());
    glBindVertexArray(buffers.vertex_array(inactive_sample.buffer));
    glDrawArrays(GL_POINTS, static_cast<GLint>(inactive_sample.first), 1);
  }
  return {};
}

Result<GLuint> SplatPasses::farthest_depths(const DrawContext& context) {
  const SurfaceTargets& targets = context.targets;
  if (auto ok = depth_tiles_.prepare(targets.width(), targets.height()); !ok) {
    return tl::unexpected(ok.error());
  }
  depth_tiles_.update(targets.layer(0), context.empty_vertex_array);
  return depth_tiles_.texture();
}

uint64_t SplatPasses::bytes() const {
  return drawn_depths_.bytes() + depth_tiles_.bytes() + sample_texture_.bytes() +
         field_texture_.bytes() + triangle_cases_.bytes() + smooth_normals_.bytes() +
         gradient_lattice_.bytes();
}

void SplatPasses::abandon() {
  drawn_depths_.abandon();
  depth_tiles_.abandon();
  sample_texture_.abandon();
  field_texture_.abandon();
  triangle_cases_.abandon();
  smooth_normals_.abandon();
  gradient_lattice_.abandon();
}

}  // namespace isosplat::render
