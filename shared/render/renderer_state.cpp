#include "shared/render/renderer_state.h"

#include <algorithm>
#include <string>

#include "shared/render/passes/image_passes.h"

namespace isosplat::render {

Renderer::State::~State() {
  if (frame_buffer) glDeleteBuffers(1, &frame_buffer);
  if (empty_vertex_array) glDeleteVertexArrays(1, &empty_vertex_array);
}

void Renderer::State::create_gl_objects() {
  limits = query_gl_limits(max_point_size);
  lit = false;
  programs.start_first();
  glGenBuffers(1, &frame_buffer);
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  glGenVertexArrays(1, &empty_vertex_array);
  dirty = true;
}

void Renderer::State::abandon_gl_objects() {
  gl_errors = {};
  chunks.abandon();
  mesh.abandon();
  programs.abandon();
  targets.abandon();
  caps.abandon();
  whole_image.abandon();
  tile_picture.abandon();
  tiled_image = {};
  lighting.abandon();
  splat_passes.abandon();
  slices.abandon();
  accumulation.abandon();
  cross_fade.abandon();
  occlusion_query.abandon();
  frame_buffer = empty_vertex_array = 0;
}

Result<void> Renderer::State::warm_up(GLuint framebuffer) {
  const PackedSample inactive{};
  const SampleRange range = chunks.buffers().add(std::span(&inactive, 1));
  layers.count = 1;
  lit = false;
  auto done = targets.prepare(1, 1, layers.count);
  if (done) {
    glEnable(GL_DEPTH_TEST);
    glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_buffer);
    done = splat_passes.warm_up(context(), chunks.buffers(), range);
  }
  if (done) done = compose(context(), layers.count, framebuffer, /*still=*/nullptr);
  chunks.buffers().remove(range);
  dirty = true;
  return done;
}

/// Whether the clipping has caps: not where samples show no surface.
bool Renderer::State::has_caps() const {
  return settings.clip_caps && cuts_of(settings) > 0 && settings.projected && mesh.is_empty() &&
         !settings.isosurfaces.empty();
}

/// Adds caps to a copy of the layers that were drawn last.
Result<void> Renderer::State::draw_caps() {
  capped = false;
  if (!has_caps()) {
    caps.release();
    return {};
  }
  const auto layer_of = std::span(layers.by_surface).first(surface_count());
  const Frame frame = make_frame({});
  const SplatFrame splats{frame, chunks.buffers(), mapping, settings.kind, lit};
  if (auto ok = caps.draw(context(), splat_passes, splats, layer_of); !ok) return ok;
  capped = true;
  return {};
}

/// Completes the layers that were drawn last.
Result<void> Renderer::State::draw_caps_and_slices() {
  if (auto ok = draw_caps(); !ok || settings.slices.empty()) return ok;
  return slices.draw(shown_context(), make_frame(drawn_offset), chunks, mapping);
}

/// Whether surfaces can be lit while they are drawn, without layers. This is faster, and possible
/// where no pixel shows several surfaces.
bool Renderer::State::can_light_directly() const {
  const auto is_translucent = [](const Isosurface& surface) {
    return surface.opacity > 0 && surface.opacity < kOpaque;
  };
  return (settings.kind == SplatKind::quad || !mesh.is_empty()) && !has_caps() &&
         settings.slices.empty() &&
         std::none_of(settings.isosurfaces.begin(), settings.isosurfaces.end(), is_translucent);
}

size_t Renderer::State::surface_count() const {
  return std::min<size_t>(settings.isosurfaces.size(), kMaxIsosurfaces);
}

void Renderer::State::assign_layers() {
  layers.count = 1;
  for (size_t i = 0; i < surface_count(); ++i) {
    const float opacity = settings.isosurfaces[i].opacity;
    layers.by_surface[i] = opacity <= 0 ? -1 : opacity >= kOpaque ? 0 : layers.count++;
  }
}

Result<void> Renderer::State::prepare_targets() {
  if (auto ok = targets.prepare(tile.width, tile.height, layers.count); !ok) return ok;
  return lit ? targets.prepare_picture() : Result<void>();
}

/// Whether the normals of layers are to be smooth. Those of squares need not be exact, and samples
/// that are not projected show no surface.
bool Renderer::State::has_smooth_normals() const {
  return settings.shading == Shading::smooth && settings.kind != SplatKind::quad &&
         settings.projected && limits.offered.float_targets && mesh.is_empty();
}

void Renderer::State::clear_targets() {
  const float farthest = 1;
  if (lit) {
    const auto& b = settings.background;
    const float alpha = std::clamp(b[3], 0.0f, 1.0f);
    const auto premultiplied = [alpha](float c) { return std::clamp(c, 0.0f, 1.0f) * alpha; };
    const float background[4] = {premultiplied(b[0]), premultiplied(b[1]), premultiplied(b[2]),
                                 alpha};
    glBindFramebuffer(GL_FRAMEBUFFER, targets.picture().framebuffer);
    glClearBufferfv(GL_COLOR, 0, background);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
    return;
  }
  const GLuint zero[4] = {0, 0, 0, 0};
  for (int layer = 0; layer < layers.count; ++layer) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
    glClearBufferuiv(GL_COLOR, 0, zero);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
  }
}

Frame Renderer::State::make_frame(ImageOffset offset) const {
  return {shown_grid(), settings, camera, tile, limits.guard_px, limits.offered.max_point_size,
          offset};
}

/// Draws all surfaces into layers, or with `light_directly` into the lit picture.
Result<void> Renderer::State::draw_surfaces(const ImageTile& part, ImageOffset offset,
                                            bool light_directly, SmoothSizes sizes) {
  tile = part;
  drawn_offset = offset;
  lit = light_directly;
  capped = false;
  statistics = FrameStatistics{};
  programs.reset_linked_count();
  assign_layers();
  if (auto ok = prepare_targets(); !ok) return ok;

  programs.set_orthographic(camera.orthographic);
  const Frame frame = make_frame(offset);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_buffer);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof(FrameBlock), &frame.block());
  statistics.chunks_culled = splat_passes.collect(chunks, frame, has_smooth_normals() ? 1 : 0);

  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  clear_targets();
  if (!mesh.is_empty()) return draw_mesh(frame);
  if (auto ok = draw_splats(frame); !ok) return ok;
  return has_smooth_normals() ? smooth_normals(frame, sizes) : Result<void>();
}

Result<void> Renderer::State::draw_splats(const Frame& frame) {
  const SplatFrame splats{frame, chunks.buffers(), mapping, settings.kind, lit};
  for (size_t i = 0; i < surface_count(); ++i) {
    const int layer = layers.by_surface[i];
    if (layer < 0) continue;
    const auto isosurface = static_cast<int>(i);
    if (auto ok = splat_passes.draw_isosurface(context(), splats, isosurface, layer); !ok)
      return ok;
  }
  return {};
}

/// Replaces the normals of the layers that were drawn last, in this frame.
Result<void> Renderer::State::smooth_normals(const Frame& frame, SmoothSizes sizes) {
  const SplatFrame splats{frame, chunks.buffers(), mapping, settings.kind, lit};
  glEnable(GL_DEPTH_TEST);
  for (int layer = 0; layer < layers.count; ++layer) {
    std::vector<int> surfaces;
    for (size_t i = 0; i < surface_count(); ++i) {
      if (layers.by_surface[i] == layer) surfaces.push_back(static_cast<int>(i));
    }
    if (surfaces.empty()) continue;
    if (auto ok = splat_passes.smooth_normals(context(), splats, surfaces, layer, sizes); !ok) {
      return ok;
    }
  }
  return {};
}

Result<void> Renderer::State::draw_mesh(const Frame& frame) {
  const auto linked = programs.image(lit ? ImagePass::lit_mesh : ImagePass::mesh);
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  glBindFramebuffer(GL_FRAMEBUFFER,
                    lit ? targets.picture().framebuffer : targets.layer_framebuffer(0));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram(program.name());
  if (lit) lighting.apply(program, settings);
  glUniformMatrix4fv(program.uniform("u_clip_from_world"), 1, GL_FALSE, frame.mesh_clip().data());
  glUniformMatrix3fv(program.uniform("u_view_from_world"), 1, GL_FALSE, frame.mesh_view().data());
  mesh.draw();
  ++statistics.draw_calls;
  return {};
}

Result<FrameStatistics> Renderer::State::finish_frame() {
#ifndef NDEBUG
  if (const GLenum error = gl_errors.collect().other; error != GL_NO_ERROR) {
    return fail(Status::gl_error, "OpenGL reports error " + std::to_string(error) +
                                      " after a frame: a bug in the renderer or the driver");
  }
#endif
  statistics.programs_linked = programs.linked_count();
  statistics.samples_resident = chunks.buffers().samples();
  statistics.gpu_bytes = chunks.buffers().bytes() + targets.bytes() + splat_passes.bytes() +
                         accumulation.sums().bytes() + cross_fade.bytes() + mesh.bytes() +
                         caps.bytes() + slices.bytes();
  drawn_tile = tile;
  dirty = false;
  return statistics;
}

Result<FrameStatistics> Renderer::State::draw(const ImageTile& part, GLuint framebuffer) {
  if (auto ok = draw_surfaces(part, {}, can_light_directly()); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = draw_caps_and_slices(); !ok) return tl::unexpected(ok.error());
  const auto shown = lit ? show_lit_picture(context(), framebuffer)
                         : compose(shown_context(), layers.count, framebuffer, /*still=*/nullptr);
  if (!shown) return tl::unexpected(shown.error());
  accumulation.restart();
  return finish_frame();
}

Result<void> Renderer::State::ensure_layers() {
  if (!lit) return {};
  return draw_surfaces(drawn_tile, {}, /*light_directly=*/false);
}

Result<void> Renderer::State::accumulate_picture() {
  if (auto ok = draw_caps_and_slices(); !ok) return ok;
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  const VolumeGrid& shown = shown_grid();
  StillPicture still;
  still.index = accumulation.pictures();
  still.scene_radius =
      static_cast<float>(visible_radius(shown, settings) / unit_of_frame_space(shown));
  const double half_height = camera_frame(camera).half_height(1);
  still.image_height = static_cast<float>(
      2 * (camera.orthographic ? half_height / unit_of_frame_space(shown) : half_height));
  if (tile != ImageTile{tile.image_width, tile.image_height}) still.whole = &whole_image;
  auto composed = compose(shown_context(), layers.count, accumulation.sums().framebuffer(), &still);
  glDisable(GL_BLEND);
  if (composed) accumulation.picture_added();
  return composed;
}

void Renderer::State::start_still_programs() {
  programs.prepare(ImagePass::present);
  programs.prepare(ComposeVariant{.several_layers = layers.count > 1,
                                  .eye_dome = settings.eye_dome > 0,
                                  .still = Lighting::has_occlusion(settings.light)});
  if (lit) {
    programs.prepare(SplatVariant{.pass = SplatPass::quad, .clipped = cuts_of(settings) > 0});
  }
  if (has_smooth_normals()) {
    splat_passes.start_smooth_normals(programs, limits.offered.max_point_size);
  }
}

Result<FrameStatistics> Renderer::State::refine(GLuint framebuffer) {
  if (accumulation.pictures() == 0) {
    // The first picture of the mean is that of the layers as draw() has left them.
    if (auto ok = accumulation.begin(drawn_tile.width, drawn_tile.height); !ok) {
      return tl::unexpected(ok.error());
    }
    if (auto ok = ensure_layers(); !ok) return tl::unexpected(ok.error());
    if (has_smooth_normals()) {
      const Frame frame = make_frame({});
      if (auto ok = smooth_normals(frame, kStillSmooth); !ok) return tl::unexpected(ok.error());
    }
    if (auto ok = accumulate_picture(); !ok) return tl::unexpected(ok.error());
  }
  const ImageOffset offset = Accumulation::offset(accumulation.pictures());
  if (auto ok = draw_surfaces(drawn_tile, offset, /*light_directly=*/false, kStillSmooth); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = accumulate_picture(); !ok) return tl::unexpected(ok.error());
  if (auto ok = present_mean(context(), accumulation, framebuffer); !ok) {
    return tl::unexpected(ok.error());
  }
  return finish_frame();
}

Result<FrameStatistics> Renderer::State::show_mean(GLuint framebuffer) {
  statistics = FrameStatistics{};
  programs.reset_linked_count();
  if (auto ok = present_mean(context(), accumulation, framebuffer); !ok) {
    return tl::unexpected(ok.error());
  }
  return finish_frame();
}

Result<void> Renderer::State::fade(float progress, GLuint framebuffer) {
  return show_fade(context(), cross_fade, progress, drawn_tile.width, drawn_tile.height,
                   framebuffer);
}

Result<void> Renderer::State::begin_occlusion_query(std::span<const ChunkHandle> handles,
                                                    int min_px) {
  std::vector<OcclusionQuery::Item> items;
  for (const DrawnChunk& chunk : chunks.visible()) {
    if (std::find(handles.begin(), handles.end(), chunk.handle) == handles.end()) continue;
    OcclusionQuery::Item item{chunk.handle, {}, chunk.regions};
    // Culled chunks are not visible: they have no samples to test.
    if (const DrawItem* drawn = splat_passes.find(chunk.handle)) {
      const SampleRange& range = drawn->chunk->range;
      item.block = drawn->block;
      item.vertex_array = chunks.buffers().vertex_array(range.buffer);
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
  for (size_t i = 0; i < surface_count(); ++i) {
    if (layers.by_surface[i] < 0) continue;
    picture.quantized_isovalues.push_back(
        mapping.quantized_isovalue(settings.isosurfaces[i].isovalue));
    picture.isosurface_layers.push_back(layers.by_surface[i]);
  }
  return occlusion_query.begin(picture, items, min_px, kFrameBinding);
}

}  // namespace isosplat::render
