#include "shared/render/passes/clip_caps.h"

#include <algorithm>
#include <array>
#include <vector>

#include "shared/render/passes/image_triangle.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

// The units of ShaderPrograms::finish.
constexpr GLenum kCutCells = 4, kStates = 5, kTiles = 6, kNearest = 7;

/// Textures that are drawn into may not be bound.
void unbind_all() {
  for (const GLenum unit : {kCutCells, kStates, kTiles, kNearest}) {
    bind_texture(unit, GL_TEXTURE_2D, 0);
  }
  bind_texture(1, GL_TEXTURE_2D_ARRAY, 0);
  bind_texture(0, GL_TEXTURE_2D_ARRAY, 0);
}

/// Begins a pass over all pixels of an image.
Result<const GlProgram*> begin_pass(const DrawContext& context, ImagePass pass,
                                    const ImageTarget& into) {
  auto program = context.programs.image(pass);
  if (!program) return program;
  unbind_all();
  glBindFramebuffer(GL_FRAMEBUFFER, into.framebuffer());
  glViewport(0, 0, into.width(), into.height());
  glUseProgram((*program)->name());
  return program;
}

int tiles_of(int px) {
  return (px + CAP_TILE_PX - 1) / CAP_TILE_PX;
}

}  // namespace

/// The isovalues of a volume that are shown, in ascending order, each once. Ranks are indices into
/// them, from 1. Isosurfaces are those of the volume.
struct ClipCaps::Ranks {
  std::vector<double> isovalues;
  std::array<GLint, MAX_ISOSURFACES> rank{};  // of each isosurface; 0: not shown
  /// By layer, and by the number of isovalues that are reached: of the isosurfaces of the layer
  /// that are reached, the one with the highest isovalue; −1: none.
  std::array<std::array<GLint, MAX_ISOSURFACES + 1>, MAX_LAYERS> cap;
  std::array<GLfloat, MAX_ISOSURFACES> scalar{};  // position of the isovalue in the colour map

  Ranks(const RenderSettings& settings, std::span<const int> isosurfaces,
        std::span<const int> layer_of) {
    const double range = settings.colour_high - settings.colour_low;
    const auto isovalue_of = [&](size_t i) {
      return settings.isosurfaces[static_cast<size_t>(isosurfaces[i])].isovalue;
    };
    for (size_t i = 0; i < layer_of.size(); ++i) {
      if (layer_of[i] < 0) continue;
      isovalues.push_back(isovalue_of(i));
      const double scalar_of = range != 0 ? (isovalue_of(i) - settings.colour_low) / range : 0;
      scalar[i] = static_cast<GLfloat>(scalar_of);
    }
    std::sort(isovalues.begin(), isovalues.end());
    isovalues.erase(std::unique(isovalues.begin(), isovalues.end()), isovalues.end());
    for (auto& caps : cap) caps.fill(-1);
    for (size_t i = 0; i < layer_of.size(); ++i) {
      if (layer_of[i] < 0) continue;
      const auto at = std::lower_bound(isovalues.begin(), isovalues.end(), isovalue_of(i));
      rank[i] = static_cast<GLint>(at - isovalues.begin()) + 1;
      auto& caps = cap[static_cast<size_t>(layer_of[i])];
      for (auto reached = static_cast<size_t>(rank[i]); reached <= isovalues.size(); ++reached) {
        GLint& shown = caps[reached];
        if (shown < 0 || rank[static_cast<size_t>(shown)] < rank[i]) shown = static_cast<GLint>(i);
      }
    }
  }
};

Result<void> ClipCaps::prepare(int width, int height, int layers) {
  if (auto ok = targets_.prepare(width, height, layers); !ok) return ok;
  glActiveTexture(GL_TEXTURE0);
  for (ImageTarget* image : {&cut_cells_, &states_}) {
    if (auto ok = image->prepare(width, height); !ok) return ok;
  }
  for (ImageTarget* image : {&tiles_, &nearest_[0], &nearest_[1]}) {
    if (auto ok = image->prepare(tiles_of(width), tiles_of(height)); !ok) return ok;
  }
  return {};
}

/// The values at the positions where rays enter the cells at cut faces.
Result<void> ClipCaps::draw_cut_cells(const DrawContext& context, SplatPasses& splat_passes,
                                      const SplatFrame& splats, const Ranks& ranks) {
  std::vector<float> reachable;
  for (const double isovalue : ranks.isovalues) {
    reachable.push_back(splats.mapping.quantized_isovalue(isovalue));
  }
  unbind_all();
  glBindFramebuffer(GL_FRAMEBUFFER, cut_cells_.framebuffer());
  const GLuint zero[4] = {0, 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, zero);
  // First the cells with a margin, then without, so that cells replace the margins of others. The
  // margin is needed where the isovalue is crossed within a pixel of the border of a cell's face:
  // no pixel of the cell then shows the part beyond the crossing.
  for (const float margin_px : {1.5f, 0.0f}) {
    for (int rank = 1; rank <= static_cast<int>(reachable.size()); ++rank) {
      const auto first = std::find(ranks.rank.begin(), ranks.rank.end(), rank);
      const int isosurface = splats.isosurfaces[static_cast<size_t>(first - ranks.rank.begin())];
      const auto drawn =
          splat_passes.draw_cut_cells(context, splats, isosurface, reachable, rank, margin_px);
      if (!drawn) return drawn;
    }
  }
  return {};
}

Result<void> ClipCaps::draw_states(const DrawContext& context, const SplatFrame& splats, int layers,
                                   const Ranks& ranks) {
  const auto program = begin_pass(context, ImagePass::cap_states, states_);
  if (!program) return tl::unexpected(program.error());
  glUniform1i((*program)->uniform("u_layers"), layers);
  set_isosurfaces(**program, splats.isosurfaces);
  glUniform1iv((*program)->uniform("u_rank"), MAX_ISOSURFACES, ranks.rank.data());
  bind_texture(kCutCells, GL_TEXTURE_2D, cut_cells_.texture());
  bind_texture(1, GL_TEXTURE_2D_ARRAY, context.targets.depths());
  bind_texture(0, GL_TEXTURE_2D_ARRAY, context.targets.surfaces());
  draw_image_triangle(context);
  return {};
}

/// Finds, for tiles without a known state, the nearest tile that has one.
Result<void> ClipCaps::find_nearest_tiles(const DrawContext& context) {
  const auto tiles = begin_pass(context, ImagePass::cap_tiles, tiles_);
  if (!tiles) return tl::unexpected(tiles.error());
  bind_texture(kStates, GL_TEXTURE_2D, states_.texture());
  draw_image_triangle(context);
  int largest = 1;
  while (2 * largest < std::max(tiles_.width(), tiles_.height())) largest *= 2;
  std::vector<int> steps{0};
  for (int step = largest; step > 0; step /= 2) steps.push_back(step);
  for (const int step : steps) {
    const auto jump = begin_pass(context, ImagePass::cap_jump, nearest_[1 - latest_]);
    if (!jump) return tl::unexpected(jump.error());
    glUniform1i((*jump)->uniform("u_step"), step);
    bind_texture(kTiles, GL_TEXTURE_2D, tiles_.texture());
    bind_texture(kNearest, GL_TEXTURE_2D, nearest_[latest_].texture());
    draw_image_triangle(context);
    latest_ = 1 - latest_;
  }
  return {};
}

Result<void> ClipCaps::draw_layers(const DrawContext& context, const SplatFrame& splats, int layers,
                                   const Ranks& ranks, int before, int order) {
  const auto linked = context.programs.image(ImagePass::caps);
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  unbind_all();
  glUseProgram(program.name());
  glUniform1i(program.uniform("u_cuts"), cuts_of(context.settings));
  constexpr int kMostOrder = 31;  // more would move caps visibly
  glUniform1i(program.uniform("u_cap_order"), kMaxIsosurfaces * std::min(order, kMostOrder));
  set_isosurfaces(program, splats.isosurfaces);
  glUniform1fv(program.uniform("u_cap_scalar"), MAX_ISOSURFACES, ranks.scalar.data());
  bind_texture(kNearest, GL_TEXTURE_2D, nearest_[latest_].texture());
  bind_texture(kTiles, GL_TEXTURE_2D, tiles_.texture());
  bind_texture(kStates, GL_TEXTURE_2D, states_.texture());
  bind_texture(1, GL_TEXTURE_2D_ARRAY, context.targets.depths());
  bind_texture(0, GL_TEXTURE_2D_ARRAY, context.targets.surfaces());
  glViewport(0, 0, targets_.width(), targets_.height());
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(before > 0 ? GL_LESS : GL_ALWAYS);
  for (int layer = 0; layer < layers; ++layer) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets_.layer_framebuffer(layer));
    glUniform1i(program.uniform("u_layer"), layer);
    glUniform1iv(program.uniform("u_cap"), MAX_ISOSURFACES + 1,
                 ranks.cap[static_cast<size_t>(layer)].data());
    draw_image_triangle(context);
  }
  glDepthFunc(GL_LESS);
  return {};
}

Result<void> ClipCaps::draw(const DrawContext& context, SplatPasses& splat_passes,
                            const SplatFrame& splats, std::span<const int> layer_of, int layers,
                            int before, int order) {
  const Ranks ranks(context.settings, splats.isosurfaces, layer_of);
  const SurfaceTargets& from = context.targets;
  if (auto ok = prepare(from.width(), from.height(), layers); !ok) return ok;
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  auto done = draw_cut_cells(context, splat_passes, splats, ranks);
  if (done) done = draw_states(context, splats, layers, ranks);
  if (done) done = find_nearest_tiles(context);
  if (done) done = draw_layers(context, splats, layers, ranks, before, order);
  unbind_all();
  return done;
}

uint64_t ClipCaps::bytes() const {
  return targets_.bytes() + cut_cells_.bytes() + states_.bytes() + tiles_.bytes() +
         nearest_[0].bytes() + nearest_[1].bytes();
}

void ClipCaps::release() {
  targets_.release();
  for (ImageTarget* image : {&cut_cells_, &states_, &tiles_, &nearest_[0], &nearest_[1]}) {
    image->release();
  }
}

void ClipCaps::abandon() {
  targets_.abandon();
  for (ImageTarget* image : {&cut_cells_, &states_, &tiles_, &nearest_[0], &nearest_[1]}) {
    image->abandon();
  }
}

}  // namespace isosplat::render
