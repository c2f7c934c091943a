#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/render/colour_maps.h"
#include "shared/render/renderer_state.h"
#include "shared/render/shader_constants.h"

namespace isosplat {
namespace {

constexpr float kOpaque = 0.999f;

Vec3f to_linear(Vec3f c) {
  // As gamma.glsl: gamma 2 for sRGB.
  const auto f = [](float v) { return std::clamp(v, 0.0f, 1.0f) * std::clamp(v, 0.0f, 1.0f); };
  return {f(c.x), f(c.y), f(c.z)};
}

}  // namespace

void Renderer::State::load_colour_map() {
  const int wanted = std::clamp(static_cast<int>(settings.colour_map), 0, kColourMaps - 1);
  glActiveTexture(GL_TEXTURE3);
  glBindTexture(GL_TEXTURE_2D, colour_map);
  if (wanted == colour_map_loaded) return;
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 256, 1, 0, GL_RGB, GL_UNSIGNED_BYTE,
               kColourMapTable[wanted]);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  colour_map_loaded = wanted;
}

/// For a program with light.glsl, which is in use.
void Renderer::State::set_light(const GlProgram& program) {
  load_colour_map();
  glUniform1i(program.uniform("u_colour_by"), settings.colour_by == ColourBy::isosurface ? 0
                                              : settings.colour_by == ColourBy::depth    ? 2
                                                                                         : 1);
  std::array<float, 4 * kMaxIsosurfaces> colours{};
  const size_t surfaces = std::min<size_t>(settings.isosurfaces.size(), kMaxIsosurfaces);
  for (size_t i = 0; i < surfaces; ++i) {
    const Isosurface& surface = settings.isosurfaces[i];
    const Vec3f linear = to_linear(surface.colour);
    const float opacity = surface.opacity >= kOpaque ? 1.0f : surface.opacity;
    std::copy_n(std::array{linear.x, linear.y, linear.z, opacity}.begin(), 4,
                colours.begin() + static_cast<std::ptrdiff_t>(4 * i));
  }
  glUniform4fv(program.uniform("u_colour"), kMaxIsosurfaces, colours.data());
  glUniform4f(program.uniform("u_light"), settings.ambient, settings.specular, settings.eye_dome,
              std::max(1.0f, static_cast<float>(targets.height()) / 700));
}

/// Whether splats can be lit as they are drawn: the fast way, where no pixel shows several
/// surfaces.
bool Renderer::State::can_be_lit_at_once() const {
  const auto is_translucent = [](const Isosurface& surface) {
    return surface.opacity > 0 && surface.opacity < kOpaque;
  };
  return (settings.kind == SplatKind::quad || mesh_indices) &&
         std::none_of(settings.isosurfaces.begin(), settings.isosurfaces.end(), is_translucent);
}

/// at_once: lights splats as they are drawn, and so makes a picture instead of a layer.
Result<void> Renderer::State::draw_layers(int width, int height, ImageOffset offset, bool at_once) {
  lit = at_once;
  statistics = FrameStatistics{};
  SplatKind kind = settings.kind;
  if (kind == SplatKind::blended && !limits.offered.float_targets) kind = SplatKind::ellipse;
  statistics.kind = kind;

  const int surfaces =
      static_cast<int>(std::min<size_t>(settings.isosurfaces.size(), kMaxIsosurfaces));
  // Layer 0 for what is opaque (or for nothing), one more for each translucent isosurface.
  layers = 1;
  for (int i = 0; i < surfaces; ++i) {
    const auto surface = static_cast<size_t>(i);
    const float opacity = settings.isosurfaces[surface].opacity;
    layer_of[surface] = opacity <= 0 ? -1 : opacity >= kOpaque ? 0 : layers++;
  }
  if (auto ok = targets.prepare(width, height, layers, kind == SplatKind::blended,
                                limits.offered.float_blend);
      !ok) {
    return ok;
  }
  if (lit) {
    if (auto ok = targets.prepare_picture(); !ok) return ok;
  }

  static const VolumeGrid kNoVolume{{2, 2, 2}};
  const Frame frame(grid ? *grid : kNoVolume, settings, camera, width, height, limits.guard_px,
                    limits.offered.max_point_size, offset);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_buffer);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof(FrameBlock), &frame.block());
  collect_items(frame);

  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  const GLuint nothing[4] = {0, 0, 0, 0};
  const float farthest = 1;
  if (lit) {
    const auto& b = settings.background;
    const float alpha = std::clamp(b[3], 0.0f, 1.0f);
    const auto coded = [alpha](float c) { return std::clamp(c, 0.0f, 1.0f) * alpha; };
    const float background[4] = {coded(b[0]), coded(b[1]), coded(b[2]), alpha};
    glBindFramebuffer(GL_FRAMEBUFFER, targets.picture().framebuffer);
    glClearBufferfv(GL_COLOR, 0, background);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
  }
  for (int layer = 0; layer < (lit ? 0 : layers); ++layer) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
    glClearBufferuiv(GL_COLOR, 0, nothing);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
  }
  if (mesh_indices) return draw_mesh(frame);
  for (int i = 0; i < surfaces; ++i) {
    const int layer = layer_of[static_cast<size_t>(i)];
    if (layer < 0) continue;
    if (auto ok = draw_isosurface(kind, frame, i, layer); !ok) return ok;
  }
  return {};
}

/// Shows the picture that was lit as it was drawn, with eye-dome lighting.
Result<void> Renderer::State::show_lit(GLuint framebuffer) {
  const int width = targets.width(), height = targets.height();
  if (settings.eye_dome <= 0) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.picture().framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return {};
  }
  const auto program = image_program(pass_darken);
  if (!program) return tl::unexpected(program.error());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  set_light(**program);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.depths());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, targets.picture_colours());
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  // Bound textures that are drawn into later would be a feedback loop.
  glBindTexture(GL_TEXTURE_2D, 0);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  ++statistics.draw_calls;
  return {};
}

Result<void> Renderer::State::compose(GLuint framebuffer, bool as_linear) {
  const int width = targets.width(), height = targets.height();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  const auto program = image_program(compose_pass());
  if (!program) return tl::unexpected(program.error());
  const GlProgram& compose_program = **program;
  glUseProgram(compose_program.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.surfaces());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.depths());
  set_light(compose_program);
  if (layers > 1) glUniform1i(compose_program.uniform("u_layers"), layers);
  glUniform1i(compose_program.uniform("u_linear"), as_linear);
  const auto& b = settings.background;
  const Vec3f background = to_linear({b[0], b[1], b[2]});
  glUniform4f(compose_program.uniform("u_background"), background.x, background.y, background.z,
              std::clamp(b[3], 0.0f, 1.0f));
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  // Bound textures that are drawn into later would be a feedback loop.
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  ++statistics.draw_calls;
  return {};
}

Result<FrameStatistics> Renderer::State::finish_frame() {
#ifndef NDEBUG
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return fail(Status::gl_error, "OpenGL reports error " + std::to_string(error) +
                                      " after a frame: a bug in the renderer or the driver");
  }
#endif
  statistics.samples_resident = buffers.samples();
  statistics.gpu_bytes =
      buffers.bytes() + targets.bytes() + drawn_depths.bytes() + depth_tiles.bytes() +
      accumulation.sums().bytes() + cross_fade.bytes() + mesh_bytes +
      uint64_t(sample_texture_rows) * SAMPLE_TEXTURE_WIDTH * sizeof(PackedSample);
  drawn_width = targets.width();
  drawn_height = targets.height();
  dirty = false;
  return statistics;
}

Result<FrameStatistics> Renderer::State::draw(int width, int height, GLuint framebuffer) {
  if (auto ok = draw_layers(width, height, {}, can_be_lit_at_once()); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = lit ? show_lit(framebuffer) : compose(framebuffer, false); !ok) {
    return tl::unexpected(ok.error());
  }
  accumulation.restart();
  return finish_frame();
}

Result<FrameStatistics> Renderer::State::refine(GLuint framebuffer) {
  const auto add_picture = [&]() -> Result<void> {
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    auto composed = compose(accumulation.sums().framebuffer(), true);
    glDisable(GL_BLEND);
    if (composed) accumulation.picture_added();
    return composed;
  };
  const int width = drawn_width, height = drawn_height;
  if (accumulation.pictures() == 0) {
    if (auto ok = accumulation.begin(width, height); !ok) return tl::unexpected(ok.error());
    if (lit) {
      if (auto ok = draw_layers(width, height, {}, false); !ok) return tl::unexpected(ok.error());
    }
    // Of the layers as they are.
    if (auto ok = add_picture(); !ok) return tl::unexpected(ok.error());
  }
  const ImageOffset offset = Accumulation::offset(accumulation.pictures());
  if (auto ok = draw_layers(width, height, offset, false); !ok) return tl::unexpected(ok.error());
  if (auto ok = add_picture(); !ok) return tl::unexpected(ok.error());

  const auto present = image_program(pass_present);
  if (!present) return tl::unexpected(present.error());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glUseProgram((*present)->name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, accumulation.sums().texture());
  glUniform1f((*present)->uniform("u_weight"), 1.0f / static_cast<float>(accumulation.pictures()));
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D, 0);
  ++statistics.draw_calls;
  return finish_frame();
}

Result<void> Renderer::State::fade(float progress, GLuint framebuffer) {
  const auto program = image_program(pass_fade);
  if (!program) return tl::unexpected(program.error());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, drawn_width, drawn_height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  glUniform1f((*program)->uniform("u_progress"), progress);
  const GLuint pictures[] = {cross_fade.from().texture(), cross_fade.to().texture()};
  for (GLenum unit : {1, 0}) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, pictures[unit]);
  }
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  // Bound textures that are drawn into later would be a feedback loop.
  for (GLenum unit : {1, 0}) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, 0);
  }
  return {};
}

Result<std::vector<Renderer::SurfacePixel>> Renderer::read_surface() {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.drawn_width == 0) return fail(Status::invalid_argument, "nothing has been drawn yet");
  const auto program = s.image_program(State::pass_read);
  if (!program) return tl::unexpected(program.error());
  const int width = s.drawn_width, height = s.drawn_height;
  if (s.lit) {
    if (auto ok = s.draw_layers(width, height, {}, false); !ok) return tl::unexpected(ok.error());
  }
  glActiveTexture(GL_TEXTURE0);
  ImageTarget words_target(GL_RGBA32UI, "to read an image");
  if (auto ok = words_target.prepare(width, height); !ok) return tl::unexpected(ok.error());
  glBindFramebuffer(GL_FRAMEBUFFER, words_target.framebuffer());
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  glBindTexture(GL_TEXTURE_2D_ARRAY, s.targets.surfaces());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, s.targets.depths());
  glBindVertexArray(s.empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  std::vector<uint32_t> words(4 * static_cast<size_t>(width) * static_cast<size_t>(height));
  glReadPixels(0, 0, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT, words.data());

  const VolumeGrid grid = s.grid.value_or(VolumeGrid{{2, 2, 2}});
  const auto unit = static_cast<float>(std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}));
  std::vector<SurfacePixel> pixels(words.size() / 4);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const uint32_t* w = &words[4 * i];
    if (w[2] == 0) continue;
    SurfacePixel& pixel = pixels[i];
    pixel.hit = true;
    std::memcpy(&pixel.depth, &w[2], 4);
    pixel.depth *= unit;
    // The inverse of encode_normal in surface_pixel.glsl.
    float x = (static_cast<float>(w[0] & 0xffff) - 32768) / 32767;
    float y = (static_cast<float>(w[0] >> 16) - 32768) / 32767;
    const float z = 1 - std::abs(x) - std::abs(y);
    if (z < 0) {
      const float folded = (1 - std::abs(y)) * (x < 0 ? -1.0f : 1.0f);
      y = (1 - std::abs(x)) * (y < 0 ? -1.0f : 1.0f);
      x = folded;
    }
    pixel.normal = Vec3f{x, y, z} * (1 / length(Vec3f{x, y, z}));
    pixel.isosurface = w[1] >> (16 + ISOSURFACE_SHIFT);
    pixel.coverage = static_cast<float>(w[1] >> 16 & 0xfff) / static_cast<float>(COVERAGE_MAX);
  }
  return pixels;
}

}  // namespace isosplat
