#include "shared/render/renderer.h"

#include <GLES3/gl3.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/sampling/sample_neighbours.h"
#include "shared/render/passes/image_passes.h"
#include "shared/render/pick/field_pick.h"
#include "shared/render/pick/slice_pick.h"
#include "shared/render/pick/volume_pick.h"
#include "shared/render/renderer_state.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

static_assert(KIND_QUAD == static_cast<int>(SplatKind::quad));
static_assert(KIND_ELLIPSE == static_cast<int>(SplatKind::ellipse));
static_assert(KIND_EXACT == static_cast<int>(SplatKind::exact));
static_assert(MAX_ISOSURFACES == kMaxIsosurfaces);
static_assert(MAX_LAYERS == kMaxTranslucent + 1 && NO_ISOSURFACE >= kMaxIsosurfaces);
static_assert(MAX_CLIP_PLANES == kMaxClipPlanes + 6 + 6);
static_assert(SLICE_NO_DATA < 1 << (16 - ISOSURFACE_SHIFT));

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

void Renderer::set_volume(const VolumeGrid& grid, const ValueMapping& mapping, VolumeId volume) {
  State& s = *state_;
  remove_volume(volume);
  s.volumes.try_emplace(volume, grid, mapping, s.buffers);
  s.choose_programs();
  s.dirty = true;
}

Result<void> Renderer::move_volume(const VolumeGrid& grid, VolumeId volume) {
  State& s = *state_;
  Volume* found = s.find_volume(volume);
  if (!found || !(found->grid.voxels == grid.voxels)) {
    return fail(Status::invalid_argument, "a volume is moved that was not set with these voxels");
  }
  found->grid = grid;
  s.choose_programs();
  s.dirty = true;
  return {};
}

void Renderer::remove_volume(VolumeId volume) {
  State& s = *state_;
  const auto found = s.volumes.find(volume);
  if (found == s.volumes.end()) return;
  if (found->second.frame_buffer) glDeleteBuffers(1, &found->second.frame_buffer);
  s.drawn.clear();
  s.volumes.erase(found);
  s.dirty = true;
}

const VolumeGrid& Renderer::grid(VolumeId volume) const {
  const Volume* found = state_->find_volume(volume);
  return found ? found->grid : kNoVolume;
}

VolumeGrid Renderer::scene_grid() const {
  const auto& volumes = state_->volumes;
  if (volumes.size() < 2) return state_->first_grid();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3d low{kInfinity, kInfinity, kInfinity}, high = low * -1.0;
  for (const auto& [id, volume] : volumes) {
    const Index3 voxels = volume.grid.voxels;
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner =
          volume.grid.world({i & 1 ? voxels.x - 1.0 : 0.0, i & 2 ? voxels.y - 1.0 : 0.0,
                             i & 4 ? voxels.z - 1.0 : 0.0});
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y), std::min(low.z, corner.z)};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y), std::max(high.z, corner.z)};
    }
  }
  VolumeGrid around{{2, 2, 2}};
  around.origin = low;
  around.spacing = high - low;
  return around;
}

Result<void> Renderer::add_chunk(ChunkHandle handle, const BlockKey& block,
                                 std::span<const PackedSample> samples, VolumeId volume) {
  std::vector<PackedSample> ordered;
  auto clusters = cluster_samples(samples, ordered);
  if (block.level > 0) mark_neighbours(ordered);
  const auto offset = reserve_chunk(handle, block, std::move(clusters), volume);
  if (!offset) return tl::unexpected(offset.error());
  if (!ordered.empty()) {
    glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(*offset),
                    static_cast<GLsizeiptr>(ordered.size() * sizeof(PackedSample)), ordered.data());
  }
  return {};
}

Result<uint64_t> Renderer::reserve_chunk(ChunkHandle handle, const BlockKey& block,
                                         std::vector<SampleCluster> clusters, VolumeId volume) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost: add the chunk again later");
  Volume* found = s.find_volume(volume);
  if (!found) {
    return fail(Status::invalid_argument, "a chunk was added before its volume was set");
  }
  if (auto ok = ChunkStore::check_block(found->grid, block); !ok) {
    return tl::unexpected(ok.error());
  }
  if (!are_clusters(clusters)) {
    return fail(Status::invalid_argument,
                "expected a chunk's clusters in the order of its regions, with boxes inside "
                "of them: decode the chunk again");
  }
  remove_chunk(handle, volume);
  ChunkStore& chunks = found->chunks;
  const SampleRange range = chunks.reserve(found->grid, handle, block, std::move(clusters));
  if (chunks.is_visible(handle) || !s.settings.slices.empty()) s.dirty = true;
  return range.offset_bytes();
}

Result<void> Renderer::check_gpu() {
  State& s = *state_;
  if (s.lost) return {};
  const GlErrors::Found errors = s.gl_errors.take();
  // Without the memory of a buffer, other calls fail as well.
  if (errors.out_of_memory) {
    const uint64_t samples = s.buffers.samples();
    for (auto& [id, volume] : s.volumes) volume.chunks.drop_unconfirmed();
    s.buffers.drop_unconfirmed();
    s.dirty = true;
    return fail(Status::out_of_memory, "the GPU has no room for " + std::to_string(samples) +
                                           " samples: remove chunks, or lower the sample budget");
  }
  s.buffers.confirm();
  if (errors.other == GL_NO_ERROR) return {};
  return fail(Status::gl_error, "OpenGL reports error " + std::to_string(errors.other) +
                                    ": a bug in the renderer or the driver");
}

void Renderer::remove_chunk(ChunkHandle handle, VolumeId volume) {
  State& s = *state_;
  Volume* found = s.find_volume(volume);
  if (!found) return;
  const bool is_shown = found->chunks.is_visible(handle) || !s.settings.slices.empty();
  if (found->chunks.remove(handle) && is_shown) s.dirty = true;
}

void Renderer::set_visible(std::span<const DrawnChunk> chunks, VolumeId volume) {
  Volume* found = state_->find_volume(volume);
  if (found && found->chunks.set_visible(chunks)) state_->dirty = true;
}

void Renderer::set_visible(std::span<const ChunkHandle> handles, VolumeId volume) {
  std::vector<DrawnChunk> chunks(handles.size());
  std::transform(handles.begin(), handles.end(), chunks.begin(),
                 [](ChunkHandle handle) { return DrawnChunk{handle}; });
  set_visible(chunks, volume);
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
  s.gl_errors.collect();  // the upload reads its own errors
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
  return read_surface_pixels(s.shown_context(),
                             static_cast<float>(unit_of_frame_space(s.first_grid())));
}

Result<std::optional<SurfacePick>> Renderer::pick(double x, double y, int width, int height) const {
  const State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the OpenGL context is lost: restore it first");
  if (s.volumes.empty()) {
    return fail(Status::invalid_argument, "there is no volume to pick in: set one");
  }
  const SceneExtent scene = s.scene_extent();
  const ImagePlace place{x, y, width, height};
  std::optional<SurfacePick> nearest;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (const auto& [id, volume] : s.volumes) {
    const auto found = pick_volume(volume.grid, volume.mapping, volume.chunks, id, s.settings,
                                   scene, s.camera, place);
    if (!found) continue;
    // Where caps lie in the same face, that of the later volume is in front.
    const double same = found->pick.cap && nearest && nearest->cap ? 1e-6 * scene.sphere.radius : 0;
    if (found->distance >= nearest_distance + same) continue;
    nearest = found->pick;
    nearest_distance = found->distance;
  }
  if (nearest) {
    const Volume& picked = *s.find_volume(s.settings.isosurfaces[nearest->isosurface].volume);
    if (picked.field) {
      const bool is_category = !s.settings.field_categories.empty();
      pick_field(picked.chunks, *picked.field, is_category, *nearest);
    }
  }
  const Volume* sliced = s.find_volume(s.settings.slice_volume);
  if (!sliced) return nearest;
  const auto ray = pick_ray(sliced->grid, scene, s.settings, s.camera, place);
  if (!ray) return nearest;
  const auto slice = pick_slice(sliced->grid, sliced->mapping, s.settings, sliced->chunks, *ray,
                                std::min(nearest_distance, ray->end));
  return slice ? slice : nearest;
}

Result<void> Renderer::begin_occlusion_query(std::span<const ChunkHandle> handles, int min_px,
                                             VolumeId volume) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.dirty || s.drawn_tile.width == 0) {
    return fail(Status::invalid_argument, "an occlusion query needs a picture that is up to date");
  }
  const Volume* found = s.find_volume(volume);
  if (!found) {
    return fail(Status::invalid_argument, "an occlusion query names a volume that was not set");
  }
  return s.begin_occlusion_query(*found, handles, min_px);
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
