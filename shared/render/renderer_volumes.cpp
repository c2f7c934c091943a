#include "shared/render/renderer_state.h"

#include <algorithm>

// Which volumes a picture shows, and their frames.
namespace isosplat::render {
namespace {

/// The smallest sphere around both.
BoundingSphere around(const BoundingSphere& a, const BoundingSphere& b) {
  const Vec3d between = b.centre - a.centre;
  const double distance = length(between);
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  const double radius = 0.5 * (distance + a.radius + b.radius);
  return {a.centre + between * ((radius - a.radius) / distance), radius};
}

}  // namespace

void upload_frame(const FrameBlock& block, GLuint buffer) {
  glBindBuffer(GL_UNIFORM_BUFFER, buffer);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof(FrameBlock), &block);
}

GLuint new_frame_buffer() {
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_UNIFORM_BUFFER, buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  return buffer;
}

Volume* Renderer::State::find_volume(VolumeId id) {
  const auto found = volumes.find(id);
  return found == volumes.end() ? nullptr : &found->second;
}

const Volume* Renderer::State::find_volume(VolumeId id) const {
  const auto found = volumes.find(id);
  return found == volumes.end() ? nullptr : &found->second;
}

FieldStyle Renderer::State::shown_style() const {
  const bool has_field = std::any_of(volumes.begin(), volumes.end(), [](const auto& entry) {
    return entry.second.field.has_value();
  });
  return mesh.is_empty() && has_field ? field_style(settings) : FieldStyle::none;
}

void Renderer::State::choose_programs() {
  programs.set_sheared(std::any_of(volumes.begin(), volumes.end(), [](const auto& entry) {
    return shear_degrees(entry.second.grid.direction) >= kMinShearDegrees;
  }));
}

SceneExtent Renderer::State::scene_extent() const {
  BoundingSphere sphere = bounding_sphere(first_grid());
  for (const auto& [id, volume] : volumes) sphere = around(sphere, bounding_sphere(volume.grid));
  return {sphere, first_grid()};
}

/// The scale of ambient occlusion and shadows, in the world.
double Renderer::State::scene_radius() const {
  return volumes.size() > 1 ? scene_extent().sphere.radius : visible_radius(first_grid(), settings);
}

Frame Renderer::State::make_frame(const VolumeGrid& grid, const SceneExtent& scene,
                                  ImageOffset offset) const {
  return {grid,  scene, settings, camera, tile, limits.guard_px, limits.offered.max_point_size,
          offset};
}

/// Makes and uploads the frames of the volumes that have isosurfaces, nearest first, and that of
/// the first volume.
void Renderer::State::make_frames(ImageOffset offset) {
  drawn.clear();
  const auto prepare = [](Volume& volume, const Frame& frame) {
    if (!volume.frame_buffer) volume.frame_buffer = new_frame_buffer();
    upload_frame(frame.block(), volume.frame_buffer);
  };
  std::map<VolumeId, std::vector<int>> isosurfaces;
  for (size_t i = 0; i < settings.isosurfaces.size(); ++i) {
    auto& own = isosurfaces[settings.isosurfaces[i].volume];
    if (own.size() < size_t{kMaxIsosurfaces}) own.push_back(static_cast<int>(i));
  }
  const SceneExtent scene = scene_extent();
  if (volumes.empty()) {
    upload_frame(make_frame(kNoVolume, scene, offset).block(), placeholder_frame);
  }
  for (auto& [id, volume] : volumes) {
    DrawnVolume each{
        id, &volume, make_frame(volume.grid, scene, offset), std::move(isosurfaces[id]), {}};
    for (const int i : each.isosurfaces) each.layers.push_back(layers.by_surface[size_t(i)]);
    const bool is_shown =
        std::any_of(each.layers.begin(), each.layers.end(), [](int layer) { return layer >= 0; });
    if (is_shown || &volume.grid == &first_grid()) prepare(volume, each.frame);
    if (is_shown) drawn.push_back(std::move(each));
  }
  const auto distance = [](const DrawnVolume& each) {
    const Index3 voxels = each.volume->grid.voxels;
    const Vec3d high{voxels.x - 1.0, voxels.y - 1.0, voxels.z - 1.0};
    return each.frame.nearest(each.frame.box({0, 0, 0}, high)) * each.frame.unit();
  };
  std::stable_sort(drawn.begin(), drawn.end(), [&](const DrawnVolume& a, const DrawnVolume& b) {
    return distance(a) < distance(b);
  });
}

void Renderer::State::bind_frame(GLuint buffer) const {
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, buffer);
}

/// For passes over the image.
void Renderer::State::bind_picture_frame() const {
  bind_frame(volumes.empty() ? placeholder_frame : volumes.begin()->second.frame_buffer);
}

SplatFrame Renderer::State::splats_of(DrawnVolume& each) const {
  Volume& volume = *each.volume;
  return {each.frame,
          volume.list,
          volume.chunks,
          volume.mapping,
          each.isosurfaces,
          settings.kind,
          lit,
          volume.field && shown_style() != FieldStyle::none ? &*volume.field : nullptr};
}

Result<void> Renderer::State::begin_occlusion_query(const Volume& volume,
                                                    std::span<const ChunkHandle> handles,
                                                    int min_px) {
  const auto each = std::find_if(drawn.begin(), drawn.end(), [&](const DrawnVolume& candidate) {
    return candidate.volume == &volume;
  });
  const bool is_drawn = each != drawn.end();
  std::vector<OcclusionQuery::Item> items;
  for (const DrawnChunk& chunk : volume.chunks.visible()) {
    if (std::find(handles.begin(), handles.end(), chunk.handle) == handles.end()) continue;
    OcclusionQuery::Item item{chunk.handle, {}, chunk.regions};
    // Culled chunks are not visible: they have no samples to test.
    if (const DrawItem* in_image = is_drawn ? volume.list.find(chunk.handle) : nullptr) {
      const SampleRange& range = in_image->chunk->range;
      item.block = in_image->block;
      item.vertex_array = buffers.vertex_array(range.buffer);
      item.first = static_cast<GLint>(range.first);
      item.count = static_cast<GLsizei>(range.count);
    }
    items.push_back(item);
  }
  const auto farthest_depths = splat_passes.farthest_depths(context());
  if (!farthest_depths) return tl::unexpected(farthest_depths.error());
  OcclusionQuery::Picture picture;
  picture.depths = targets.depths();
  picture.layers = layers.count;
  picture.orthographic = camera.orthographic;
  picture.farthest_depths = *farthest_depths;
  for (size_t i = 0; is_drawn && i < each->isosurfaces.size(); ++i) {
    if (each->layers[i] < 0) continue;
    const Isosurface& surface = settings.isosurfaces[size_t(each->isosurfaces[i])];
    picture.quantized_isovalues.push_back(volume.mapping.quantized_isovalue(surface.isovalue));
    picture.isosurface_layers.push_back(each->layers[i]);
  }
  if (is_drawn) bind_frame(volume.frame_buffer);
  const auto begun = occlusion_query.begin(picture, items, min_px, kFrameBinding);
  bind_picture_frame();
  // The picture shows coarse chunks. On a slow GPU the next one, with the chunks that the query
  // finds, will be of squares. The driver compiles while these chunks are being fetched.
  if (begun && !lit) start_lit_programs();
  return begun;
}

void Renderer::State::start_lit_programs() {
  // A driver that compiles at once would delay the caller.
  if (!limits.parallel_compile) return;
  programs.prepare(SplatVariant{.pass = SplatPass::quad,
                                .clipped = cuts_of(settings) > 0,
                                .lit = true,
                                .field = shown_style()});
  if (settings.eye_dome > 0) programs.prepare(ImagePass::darken);
}

}  // namespace isosplat::render
