#include "shared/render/renderer.h"

#include <GLES3/gl3.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/sampling/sample_neighbours.h"
#include "shared/render/passes/image_passes.h"
#include "shared/render/pick/cap_pick.h"
#include "shared/render/pick/ray_hits.h"
#include "shared/render/pick/slice_pick.h"
#include "shared/render/renderer_state.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

static_assert(KIND_QUAD == static_cast<int>(SplatKind::quad));
static_assert(KIND_ELLIPSE == static_cast<int>(SplatKind::ellipse));
static_assert(KIND_EXACT == static_cast<int>(SplatKind::exact));
static_assert(MAX_ISOSURFACES == kMaxIsosurfaces && MAX_LAYERS == kMaxIsosurfaces + 1);
static_assert(MAX_CLIP_PLANES == kMaxClipPlanes + 6);
static_assert(SLICE_VALUES >= kMaxIsosurfaces && SLICE_NO_DATA < 16);

}  // namespace

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(float max_point_size) {
  auto state = std::make_unique<State>();
  state->max_point_size = max_point_size;
  state->create_gl_objects();
  return std::unique_ptr<Renderer>(new Renderer(std::move(state)));
}

const RendererLimits& Renderer::limits() const {
  return state_->limits.offered;
}

bool Renderer::is_compiled() const {
  const State& s = *state_;
  return s.lost || !s.limits.parallel_compile || s.programs.is_compiled();
}

Result<void> Renderer::warm_up(uint32_t framebuffer) {
  if (state_->lost) return fail(Status::gl_error, "the GL context is lost");
  return state_->warm_up(framebuffer);
}

void Renderer::set_volume(const VolumeGrid& grid, const ValueMapping& mapping) {
  state_->grid = grid;
  state_->mapping = mapping;
  state_->programs.set_sheared(shear_degrees(grid.direction) >= kMinShearDegrees);
  state_->chunks.clear();
  state_->dirty = true;
}

const VolumeGrid& Renderer::grid() const {
  return state_->shown_grid();
}

Result<void> Renderer::add_chunk(ChunkHandle handle, const BlockKey& block,
                                 std::span<const PackedSample> samples) {
  std::vector<PackedSample> ordered;
  auto clusters = cluster_samples(samples, ordered);
  if (block.level > 0) mark_neighbours(ordered);
  const auto offset = reserve_chunk(handle, block, std::move(clusters));
  if (!offset) return tl::unexpected(offset.error());
  if (!ordered.empty()) {
    glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(*offset),
                    static_cast<GLsizeiptr>(ordered.size() * sizeof(PackedSample)), ordered.data());
  }
  return {};
}

Result<uint64_t> Renderer::reserve_chunk(ChunkHandle handle, const BlockKey& block,
                                         std::vector<SampleCluster> clusters) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost: add the chunk again later");
  if (!s.grid) return fail(Status::invalid_argument, "a chunk was added before any volume was set");
  if (auto ok = ChunkStore::check_block(*s.grid, block); !ok) {
    return tl::unexpected(ok.error());
  }
  if (!are_clusters(clusters)) {
    return fail(Status::invalid_argument, "a chunk's clusters are not in the order of its regions");
  }
  remove_chunk(handle);
  const SampleRange range = s.chunks.reserve(*s.grid, handle, block, std::move(clusters));
  if (s.chunks.is_visible(handle) || !s.settings.slices.empty()) s.dirty = true;
  return range.offset_bytes();
}

Result<void> Renderer::check_gpu() {
  State& s = *state_;
  if (s.lost) return {};
  const GlErrors::Found errors = s.gl_errors.take();
  // Without the memory of a buffer, other calls fail as well.
  if (errors.out_of_memory) {
    const uint64_t samples = s.chunks.buffers().samples();
    s.chunks.drop_unconfirmed();
    s.dirty = true;
    return fail(Status::out_of_memory, "the GPU has no room for " + std::to_string(samples) +
                                           " samples: remove chunks, or lower the sample budget");
  }
  s.chunks.buffers().confirm();
  if (errors.other == GL_NO_ERROR) return {};
  return fail(Status::gl_error, "OpenGL reports error " + std::to_string(errors.other) +
                                    ": a bug in the renderer or the driver");
}

void Renderer::remove_chunk(ChunkHandle handle) {
  State& s = *state_;
  const bool is_shown = s.chunks.is_visible(handle) || !s.settings.slices.empty();
  if (s.chunks.remove(handle) && is_shown) s.dirty = true;
}

void Renderer::set_visible(std::span<const DrawnChunk> chunks) {
  if (state_->chunks.set_visible(chunks)) state_->dirty = true;
}

void Renderer::set_visible(std::span<const ChunkHandle> handles) {
  std::vector<DrawnChunk> chunks(handles.size());
  std::transform(handles.begin(), handles.end(), chunks.begin(),
                 [](ChunkHandle handle) { return DrawnChunk{handle}; });
  set_visible(chunks);
}

void Renderer::set_settings(const RenderSettings& settings) {
  if (settings == state_->settings) return;
  state_->settings = settings;
  state_->dirty = true;
}

const RenderSettings& Renderer::settings() const {
  return state_->settings;
}

void Renderer::set_camera(const Camera& camera) {
  if (camera == state_->camera) return;
  state_->camera = camera;
  state_->dirty = true;
}

const Camera& Renderer::camera() const {
  return state_->camera;
}

Result<void> Renderer::set_mesh(std::span<const MeshVertex> vertices,
                                std::span<const uint32_t> triangles) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  s.dirty = true;
  s.gl_errors.collect();  // the upload asks for its own errors
  return s.mesh.upload(vertices, triangles);
}

bool Renderer::needs_redraw(int width, int height) const {
  const State& s = *state_;
  return !s.lost && (s.dirty || s.drawn_tile != ImageTile{width, height});
}

Result<FrameStatistics> Renderer::draw(int width, int height, uint32_t framebuffer) {
  if (state_->lost) return fail(Status::gl_error, "the GL context is lost");
  if (width < 1 || height < 1 || width > kMaxImageSize || height > kMaxImageSize ||
      std::max(width, height) > state_->limits.offered.max_texture_size) {
    return fail(
        Status::invalid_argument,
        "an image of " + std::to_string(width) + " × " + std::to_string(height) +
            " pixels is not possible here: 1 to " +
            std::to_string(std::min(kMaxImageSize, state_->limits.offered.max_texture_size)));
  }
  return state_->draw({width, height}, framebuffer);
}

bool Renderer::can_refine(int width, int height) const {
  const State& s = *state_;
  return !s.lost && !needs_redraw(width, height) && s.limits.offered.float_targets &&
         s.mesh.is_empty() && s.accumulation.pictures() < Accumulation::kPictures;
}

bool Renderer::prepare_refine() {
  if (state_->lost) return true;
  state_->start_still_programs();
  if (!is_compiled()) return false;
  state_->programs.finish_started();
  return true;
}

Result<FrameStatistics> Renderer::refine(int width, int height, uint32_t framebuffer) {
  if (!can_refine(width, height)) {
    return fail(Status::invalid_argument, "this picture cannot be refined: draw it first");
  }
  return state_->refine(framebuffer);
}

Result<FrameStatistics> Renderer::draw_still(int width, int height, uint32_t framebuffer) {
  State& s = *state_;
  const bool is_current = !s.lost && !needs_redraw(width, height);
  if (is_current && s.accumulation.pictures() == Accumulation::kPictures) {
    return s.show_mean(framebuffer);
  }
  Result<FrameStatistics> drawn =
      can_refine(width, height) ? s.statistics : draw(width, height, framebuffer);
  while (drawn && can_refine(width, height)) drawn = refine(width, height, framebuffer);
  return drawn;
}

Result<void> Renderer::hold_picture(uint32_t framebuffer) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.drawn_tile.width == 0) return fail(Status::invalid_argument, "nothing has been drawn yet");
  return s.cross_fade.set_from(framebuffer, s.drawn_tile.width, s.drawn_tile.height);
}

Result<bool> Renderer::begin_fade(uint32_t framebuffer) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (!s.cross_fade.has_from(s.drawn_tile.width, s.drawn_tile.height)) return false;
  s.cross_fade.set_to(framebuffer);
  if (auto ok = s.fade(0, framebuffer); !ok) return tl::unexpected(ok.error());
  return true;
}

Result<void> Renderer::fade(float progress, uint32_t framebuffer) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (auto ok = s.fade(std::clamp(progress, 0.0f, 1.0f), framebuffer); !ok) return ok;
  if (progress >= 1) s.cross_fade.finish();
  return {};
}

Result<std::vector<SurfacePixel>> Renderer::read_surface() {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.drawn_tile.width == 0) return fail(Status::invalid_argument, "nothing has been drawn yet");
  if (auto ok = s.ensure_layers(); !ok) return tl::unexpected(ok.error());
  const VolumeGrid grid = s.grid.value_or(VolumeGrid{{2, 2, 2}});
  const double unit = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  return read_surface_pixels(s.shown_context(), static_cast<float>(unit));
}

Result<std::optional<SurfacePick>> Renderer::pick(double x, double y, int width, int height) const {
  const State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the OpenGL context is lost: restore it first");
  if (!s.grid) return fail(Status::invalid_argument, "there is no volume to pick in: set one");
  const auto ray = pick_ray(*s.grid, s.settings, s.camera, x, y, width, height);
  if (!ray) return std::nullopt;
  std::vector<float> quantized_isovalues;
  for (const Isosurface& surface : s.settings.isosurfaces) {
    if (quantized_isovalues.size() == kMaxIsosurfaces) break;
    quantized_isovalues.push_back(surface.opacity > 0
                                      ? s.mapping.quantized_isovalue(surface.isovalue)
                                      : std::numeric_limits<float>::quiet_NaN());
  }
  const auto is_any_active = [&](CellInterval interval) {
    return std::any_of(quantized_isovalues.begin(), quantized_isovalues.end(),
                       [interval](float q) { return is_active(interval, q); });
  };
  std::vector<PickHit> hits;
  std::vector<PackedSample> samples;
  for (const DrawnChunk& visible : s.chunks.visible()) {
    const ChunkStore::Chunk* chunk = s.chunks.find(visible.handle);
    if (!chunk || !is_any_active(chunk->interval)) continue;
    if (!meets_box(*ray, chunk->low, chunk->high)) continue;
    const double size = std::ldexp(1.0, static_cast<int>(chunk->block.level));
    const Index3 block = chunk->block.index;
    const Vec3d corner =
        Vec3d{double(block.x), double(block.y), double(block.z)} * (kBlockCells * size);
    for (const SampleCluster& cluster : chunk->clusters) {
      if (!visible.regions.contains(cluster.region_index())) continue;
      if (!is_any_active(cluster.interval)) continue;
      const auto place = [&](Vec3<uint8_t> cell) {
        return corner + Vec3d{double(cell.x), double(cell.y), double(cell.z)} * size;
      };
      if (!meets_box(*ray, place(cluster.low), place(cluster.high))) continue;
      samples.resize(cluster.count);
      s.chunks.buffers().read(chunk->range, cluster.first, samples);
      add_hits(*ray, chunk->block, samples, quantized_isovalues, hits);
    }
  }
  std::optional<SurfacePick> pick = pick_cap(*s.grid, s.settings, *ray, hits);
  double nearest = ray->end;
  for (const PickHit& hit : hits) nearest = std::min(nearest, hit.distance);
  if (pick) nearest = ray->begin;
  if (!pick) pick = nearest_pick(*s.grid, s.mapping, *ray, std::move(hits));
  if (pick) pick->value = s.settings.isosurfaces[pick->isosurface].isovalue;
  const auto slice = pick_slice(*s.grid, s.mapping, s.settings, s.chunks, *ray, nearest);
  return slice ? slice : pick;
}

Result<void> Renderer::begin_occlusion_query(std::span<const ChunkHandle> handles, int min_px) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.dirty || s.drawn_tile.width == 0) {
    return fail(Status::invalid_argument, "an occlusion query needs a picture that is up to date");
  }
  return s.begin_occlusion_query(handles, min_px);
}

std::optional<std::vector<ChunkVisibility>> Renderer::take_occlusion_query() {
  if (state_->lost) return std::nullopt;
  return state_->occlusion_query.take();
}

void Renderer::context_lost() {
  state_->lost = true;
  state_->abandon_gl_objects();
}

Result<void> Renderer::context_restored() {
  if (!state_->lost) return {};
  state_->create_gl_objects();
  state_->lost = false;
  return {};
}

}  // namespace isosplat::render
