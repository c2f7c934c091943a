#include "shared/render/renderer_state.h"

#include <algorithm>
#include <string>

#include "shared/render/passes/image_passes.h"

namespace isosplat::render {
Renderer::State::~State() {
  for (const auto& [id, volume] : volumes) {
    if (volume.frame_buffer) glDeleteBuffers(1, &volume.frame_buffer);
  }
  if (placeholder_frame) glDeleteBuffers(1, &placeholder_frame);
  if (empty_vertex_array) glDeleteVertexArrays(1, &empty_vertex_array);
}

void Renderer::State::create_gl_objects() {
  limits = query_gl_limits(max_point_size);
  lit = false;
  programs.start_first();
  placeholder_frame = new_frame_buffer();
  glGenVertexArrays(1, &empty_vertex_array);
  dirty = true;
}

void Renderer::State::abandon_gl_objects() {
  gl_errors = {};
  for (auto& [id, volume] : volumes) {
    volume.chunks.abandon();
    volume.list.clear();
    volume.frame_buffer = 0;
  }
  drawn.clear();
  buffers.abandon();
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
  placeholder_frame = empty_vertex_array = 0;
}

Result<void> Renderer::State::warm_up(GLuint framebuffer) {
  const PackedSample inactive{};
  const SampleRange range = buffers.add(std::span(&inactive, 1));
  layers.count = 1;
  lit = false;
  auto done = targets.prepare(1, 1, layers.count);
  if (done) {
    glEnable(GL_DEPTH_TEST);
    bind_frame(placeholder_frame);
    done = splat_passes.warm_up(context(), buffers, range);
  }
  if (done) done = compose(context(), layers.count, framebuffer, /*still=*/nullptr);
  buffers.remove(range);
  dirty = true;
  return done;
}

/// Whether the clipping has caps. It has none if samples show no surface.
bool Renderer::State::has_caps() const {
  return settings.clip_caps && cuts_of(settings) > 0 && settings.projected && mesh.is_empty() &&
         !settings.isosurfaces.empty();
}

/// Adds caps to a copy of the layers that were drawn last. Whether a place is inside of the solid
/// follows from the surfaces of its own volume behind it. So each of several volumes is drawn
/// alone, and then all of them again.
Result<void> Renderer::State::draw_caps() {
  capped = false;
  if (!has_caps() || drawn.empty()) {
    caps.release();
    return {};
  }
  int before = 0;
  for (DrawnVolume& each : drawn) {
    if (drawn.size() > 1) {
      clear_targets();
      if (auto ok = draw_splats({&each, 1}); !ok) return ok;
      if (auto ok = smooth_normals({&each, 1}); !ok) return ok;
    }
    bind_frame(each.volume->frame_buffer);
    const auto is_before = [&](const DrawnVolume& other) { return other.id < each.id; };
    const auto order = std::count_if(drawn.begin(), drawn.end(), is_before);
    const auto done = caps.draw(context(), splat_passes, splats_of(each), each.layers, layers.count,
                                before++, static_cast<int>(order));
    if (!done) return done;
  }
  if (drawn.size() > 1) {
    clear_targets();
    if (auto ok = draw_splats(drawn); !ok) return ok;
    if (auto ok = smooth_normals(drawn); !ok) return ok;
  }
  capped = true;
  return {};
}

/// Completes the layers that were drawn last.
Result<void> Renderer::State::draw_caps_and_slices() {
  if (auto ok = draw_caps(); !ok || settings.slices.empty()) return ok;
  Volume* volume = find_volume(settings.slice_volume);
  if (!volume) return {};
  const Frame frame = make_frame(volume->grid, scene_extent(), drawn_offset);
  if (!volume->frame_buffer) volume->frame_buffer = new_frame_buffer();
  upload_frame(frame.block(), volume->frame_buffer);
  bind_frame(volume->frame_buffer);
  const auto done = slices.draw(shown_context(), frame, volume->chunks, volume->mapping);
  bind_picture_frame();
  return done;
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

void Renderer::State::assign_layers() {
  layers.count = 1;
  layers.by_surface.clear();
  layers.isosurfaces = settings.isosurfaces;
  for (Isosurface& surface : layers.isosurfaces) {
    const bool has_layer = surface.opacity < kOpaque && layers.count <= kMaxTranslucent;
    layers.by_surface.push_back(surface.opacity <= 0 ? -1 : has_layer ? layers.count++ : 0);
    if (!has_layer) surface.opacity = 1;
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

/// Draws all surfaces into layers, or with `light_directly` into the lit picture.
Result<void> Renderer::State::draw_surfaces(const ImageTile& part, ImageOffset offset,
                                            bool light_directly, SmoothSizes sizes) {
  tile = part;
  drawn_offset = offset;
  lit = light_directly;
  capped = false;
  statistics = FrameStatistics{};
  programs.reset_linked_count();
  smooth_sizes = sizes;
  assign_layers();
  if (auto ok = prepare_targets(); !ok) return ok;

  programs.set_orthographic(camera.orthographic);
  make_frames(offset);
  for (DrawnVolume& each : drawn) {
    statistics.chunks_culled +=
        each.volume->list.collect(each.volume->chunks, each.frame, has_smooth_normals() ? 1 : 0);
  }

  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  clear_targets();
  if (!mesh.is_empty()) return draw_mesh(make_frame(first_grid(), scene_extent(), offset));
  if (auto ok = draw_splats(drawn); !ok) return ok;
  return smooth_normals(drawn);
}

Result<void> Renderer::State::draw_splats(std::span<DrawnVolume> of) {
  for (DrawnVolume& each : of) {
    bind_frame(each.volume->frame_buffer);
    for (size_t i = 0; i < each.isosurfaces.size(); ++i) {
      if (each.layers[i] < 0) continue;
      const auto done = splat_passes.draw_isosurface(context(), splats_of(each),
                                                     each.isosurfaces[i], each.layers[i]);
      if (!done) return done;
    }
  }
  bind_picture_frame();
  return {};
}

/// Replaces the normals of the layers that were drawn last, if they are to be smooth.
Result<void> Renderer::State::smooth_normals(std::span<DrawnVolume> of) {
  if (!has_smooth_normals()) return {};
  glEnable(GL_DEPTH_TEST);
  for (DrawnVolume& each : of) {
    bind_frame(each.volume->frame_buffer);
    for (int layer = 0; layer < layers.count; ++layer) {
      std::vector<int> surfaces;
      for (size_t i = 0; i < each.isosurfaces.size(); ++i) {
        if (each.layers[i] == layer) surfaces.push_back(each.isosurfaces[i]);
      }
      if (surfaces.empty()) continue;
      const auto done =
          splat_passes.smooth_normals(context(), splats_of(each), surfaces, layer, smooth_sizes);
      if (!done) return done;
    }
  }
  bind_picture_frame();
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
  if (lit)
    lighting.apply(
        program, settings,
        std::span(layers.isosurfaces).first(std::min<size_t>(layers.isosurfaces.size(), 1)));
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
  statistics.samples_resident = buffers.samples();
  statistics.gpu_bytes = buffers.bytes() + targets.bytes() + splat_passes.bytes() +
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
  const double unit = unit_of_frame_space(first_grid());
  StillPicture still;
  still.index = accumulation.pictures();
  still.scene_radius = static_cast<float>(scene_radius() / unit);
  const double half_height = camera_frame(camera).half_height(1);
  still.image_height =
      static_cast<float>(2 * (camera.orthographic ? half_height / unit : half_height));
  if (tile != ImageTile{tile.image_width, tile.image_height}) still.whole = &whole_image;
  auto composed = compose(shown_context(), layers.count, accumulation.sums().framebuffer(), &still);
  glDisable(GL_BLEND);
  if (composed) accumulation.picture_added();
  return composed;
}

void Renderer::State::start_still_programs() {
  programs.prepare(ImagePass::present);
  programs.prepare(
      ComposeVariant{.several_layers = layers.count > 1,
                     .eye_dome = settings.eye_dome > 0,
                     .still = Lighting::has_occlusion(settings.light),
                     .many_surfaces = settings.isosurfaces.size() > size_t{kMaxIsosurfaces},
                     .field = shown_style()});
  if (lit) {
    const bool clipped = cuts_of(settings) > 0;
    const FieldStyle field = shown_style();
    programs.prepare(SplatVariant{.pass = SplatPass::quad, .clipped = clipped, .field = field});
    const auto is_triangles = [&](const DrawItem& item) {
      return is_drawn_as_triangles(item, settings);
    };
    for (const DrawnVolume& each : drawn) {
      const auto& items = each.volume->list.items();
      if (std::none_of(items.begin(), items.end(), is_triangles)) continue;
      programs.prepare({.pass = SplatPass::triangles,
                        .pulled = true,
                        .clipped = clipped,
                        .smooth = settings.shading == Shading::smooth &&
                                  GradientLattice::has_triangles(context(), each.volume->list),
                        .field = field});
    }
  }
  if (!has_smooth_normals()) return;
  for (const DrawnVolume& each : drawn) {
    start_smooth_normals(programs, each.volume->list, limits.offered.max_point_size);
  }
}

Result<FrameStatistics> Renderer::State::refine(GLuint framebuffer) {
  if (accumulation.pictures() == 0) {
    // The first picture of the mean is that of the layers as draw() has left them.
    if (auto ok = accumulation.begin(drawn_tile.width, drawn_tile.height); !ok) {
      return tl::unexpected(ok.error());
    }
    if (auto ok = ensure_layers(); !ok) return tl::unexpected(ok.error());
    smooth_sizes = kStillSmooth;
    if (auto ok = smooth_normals(drawn); !ok) return tl::unexpected(ok.error());
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

}  // namespace isosplat::render
