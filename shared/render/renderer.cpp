#include "shared/render/renderer.h"

#include <GLES3/gl3.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <unordered_map>

#include "shared/render/colour_maps.h"
#include "shared/render/frame.h"
#include "shared/render/gl_program.h"
#include "shared/render/sample_buffers.h"
#include "shared/render/shader_constants.h"
#include "shared/render/surface_targets.h"

namespace isosplat {
namespace {

static_assert(KIND_QUAD == static_cast<int>(SplatKind::quad));
static_assert(KIND_ELLIPSE == static_cast<int>(SplatKind::ellipse));
static_assert(KIND_BLENDED == static_cast<int>(SplatKind::blended));
static_assert(KIND_EXACT == static_cast<int>(SplatKind::exact));
static_assert(MAX_ISOSURFACES == kMaxIsosurfaces && MAX_LAYERS == kMaxIsosurfaces + 1);
static_assert(MAX_CLIP_PLANES == kMaxClipPlanes + 6);

constexpr GLuint kFrameBinding = 0;
constexpr float kOpaque = 0.999f;
constexpr int kMaxImageSize = 16384;

/// Image size beyond the edges for points whose centres lie outside: wider than any useful point.
constexpr float kMaxGuardPx = 512;

/// Passes of drawing splats; each is a program.
enum Pass { pass_quad, pass_ellipse, pass_exact, pass_visibility, pass_accumulate, kPasses };

struct SplatProgram {
  GlProgram program;
  GLint block = -1, isocode = -1, isosurface = -1, scalar = -1, regions = -1;
};

struct Chunk {
  SampleRange range;
  BlockKey block;
  CellInterval interval;  // of all samples: min of mins, max of maxes
  Vec3d low, high;        // box in cells of level 0
};

/// A visible chunk in this frame.
struct DrawItem {
  const Chunk* chunk;
  double nearest;
  std::array<float, 4> block;
  std::array<GLuint, 2> regions;
  float largest_px;  // no splat of it is larger
};

struct Limits {
  RendererLimits offered;
  float guard_px = 0;
};

bool has_extension(std::string_view name) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const auto* text =
        reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (!text) continue;
    std::string_view found = text;
    if (found.substr(0, 3) == "GL_") found.remove_prefix(3);  // WebGL names some both ways
    if (found == name) return true;
  }
  return false;
}

Limits ask_limits(float largest_wanted) {
  Limits limits;
  GLfloat point_sizes[2] = {1, 1};
  glGetFloatv(GL_ALIASED_POINT_SIZE_RANGE, point_sizes);
  GLint viewport[2] = {0, 0};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limits.offered.max_texture_size);
  limits.offered.max_point_size = std::min({point_sizes[1], 2 * kMaxGuardPx, largest_wanted});
  limits.offered.float_targets = has_extension("EXT_color_buffer_float");
  limits.offered.float_blend = has_extension("EXT_float_blend");
  if (const auto* text = reinterpret_cast<const char*>(glGetString(GL_RENDERER))) {
    limits.offered.renderer = text;
  }
  limits.guard_px = std::ceil(0.5f * limits.offered.max_point_size);
  return limits;
}

Vec3f to_linear(Vec3f c) {
  // As compose.frag.glsl.
  const auto f = [](float v) { return std::clamp(v, 0.0f, 1.0f) * std::clamp(v, 0.0f, 1.0f); };
  return {f(c.x), f(c.y), f(c.z)};
}

}  // namespace

bool operator==(const RenderSettings& a, const RenderSettings& b) {
  const auto same_surface = [](const Isosurface& x, const Isosurface& y) {
    return x.isovalue == y.isovalue && x.colour == y.colour && x.opacity == y.opacity;
  };
  const auto same_plane = [](const ClipPlane& x, const ClipPlane& y) {
    return x.normal == y.normal && x.offset == y.offset;
  };
  return std::equal(a.isosurfaces.begin(), a.isosurfaces.end(), b.isosurfaces.begin(),
                    b.isosurfaces.end(), same_surface) &&
         a.kind == b.kind && a.colour_by == b.colour_by && a.colour_map == b.colour_map &&
         a.colour_low == b.colour_low && a.colour_high == b.colour_high &&
         a.background == b.background && a.ambient == b.ambient && a.specular == b.specular &&
         a.eye_dome == b.eye_dome && a.splat_scale == b.splat_scale && a.projected == b.projected &&
         a.displaced == b.displaced &&
         std::equal(a.clip_planes.begin(), a.clip_planes.end(), b.clip_planes.begin(),
                    b.clip_planes.end(), same_plane) &&
         a.clip_box_low == b.clip_box_low && a.clip_box_high == b.clip_box_high;
}

struct Renderer::State {
  float max_point_size = 1;
  Limits limits;
  bool lost = false;
  bool dirty = true;
  int drawn_width = 0, drawn_height = 0;

  std::optional<VolumeGrid> grid;
  ValueMapping mapping;
  RenderSettings settings;
  Camera camera;

  std::unordered_map<uint64_t, Chunk> chunks;
  std::vector<VisibleChunk> visible;
  SampleBuffers buffers;

  SurfaceTargets targets;
  SplatProgram splat_programs[kPasses][2][2];  // [pass][pulled][clipped]
  GlProgram normalise_program, read_program, mesh_program;
  GlProgram compose_programs[2];  // one layer, several
  GLuint frame_buffer = 0, empty_vertex_array = 0, colour_map = 0;
  int colour_map_loaded = -1;
  GLuint sample_texture = 0;
  int sample_texture_rows = 0;

  GLuint mesh_vertex_array = 0, mesh_buffers[2] = {0, 0};
  GLsizei mesh_indices = 0;
  uint64_t mesh_bytes = 0;

  std::vector<DrawItem> items;  // kept between frames: no allocation once warm
  FrameStatistics statistics;

  Result<void> make_gl_objects();
  void forget_gl_objects();
  void release_gl_objects();
  Result<SplatProgram*> splat_program(Pass pass, bool pulled, bool clipped);
  bool is_visible(uint64_t id) const {
    return std::any_of(visible.begin(), visible.end(),
                       [id](const VisibleChunk& chunk) { return chunk.id == id; });
  }
  void collect_items(const Frame& frame);
  Result<void> draw_splats(Pass pass, const Frame& frame, int isosurface);
  Result<void> draw_isosurface(SplatKind kind, const Frame& frame, int isosurface, int layer);
  void load_samples(const SampleRange& range);
  void load_colour_map();
  std::array<float, 3> scalar_weights(const Frame& frame, const Isosurface& surface,
                                      uint32_t level) const;
  Result<void> draw_mesh(const Frame& frame);
  Result<FrameStatistics> draw(int width, int height, GLuint framebuffer);
};

Result<void> Renderer::State::make_gl_objects() {
  limits = ask_limits(max_point_size);
  auto normalise = GlProgram::link("", {"image.vert.glsl"},
                                   {"frame.glsl", "surface_pixel.glsl", "normalise.frag.glsl"});
  if (!normalise) return tl::unexpected(normalise.error());
  for (int several = 0; several < 2; ++several) {
    auto compose = GlProgram::link(several ? "" : "#define ONE_LAYER\n", {"image.vert.glsl"},
                                   {"frame.glsl", "surface_pixel.glsl", "compose.frag.glsl"});
    if (!compose) return tl::unexpected(compose.error());
    compose_programs[several] = std::move(*compose);
  }
  auto read = GlProgram::link("", {"image.vert.glsl"}, {"frame.glsl", "read.frag.glsl"});
  if (!read) return tl::unexpected(read.error());
  auto mesh = GlProgram::link("", {"mesh.vert.glsl"}, {"surface_pixel.glsl", "mesh.frag.glsl"});
  if (!mesh) return tl::unexpected(mesh.error());
  normalise_program = std::move(*normalise);
  read_program = std::move(*read);
  mesh_program = std::move(*mesh);
  for (const GlProgram* program :
       {&normalise_program, &compose_programs[0], &compose_programs[1], &read_program}) {
    glUseProgram(program->name());
    glUniformBlockBinding(program->name(), glGetUniformBlockIndex(program->name(), "Frame"),
                          kFrameBinding);
  }
  glUseProgram(normalise_program.name());
  glUniform1i(normalise_program.uniform("u_normals"), 0);
  glUniform1i(normalise_program.uniform("u_sums"), 1);
  for (const GlProgram* program : {&compose_programs[0], &compose_programs[1], &read_program}) {
    glUseProgram(program->name());
    glUniform1i(program->uniform("u_surfaces"), 0);
    glUniform1i(program->uniform("u_depths"), 1);
  }
  for (const GlProgram& program : compose_programs) {
    glUseProgram(program.name());
    glUniform1i(program.uniform("u_colour_map"), 2);
  }

  glGenBuffers(1, &frame_buffer);
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  glGenVertexArrays(1, &empty_vertex_array);
  glGenTextures(1, &colour_map);
  colour_map_loaded = -1;
  dirty = true;
  return {};
}

void Renderer::State::forget_gl_objects() {
  chunks.clear();
  visible.clear();
  items.clear();
  buffers.forget();
  targets.forget();
  for (auto& pass : splat_programs) {
    for (auto& pulled : pass) {
      for (auto& program : pulled) {
        program.program.forget();
        program = SplatProgram{};
      }
    }
  }
  for (GlProgram* program : {&normalise_program, &compose_programs[0], &compose_programs[1],
                             &read_program, &mesh_program}) {
    program->forget();
  }
  frame_buffer = empty_vertex_array = colour_map = sample_texture = 0;
  mesh_vertex_array = mesh_buffers[0] = mesh_buffers[1] = 0;
  sample_texture_rows = 0;
  mesh_indices = 0;
  mesh_bytes = 0;
}

void Renderer::State::release_gl_objects() {
  buffers.release();
  targets.release();
  for (auto& pass : splat_programs) {
    for (auto& pulled : pass) {
      for (auto& program : pulled) program = SplatProgram{};
    }
  }
  glDeleteBuffers(1, &frame_buffer);
  glDeleteVertexArrays(1, &empty_vertex_array);
  glDeleteTextures(1, &colour_map);
  if (sample_texture) glDeleteTextures(1, &sample_texture);
  if (mesh_vertex_array) {
    glDeleteVertexArrays(1, &mesh_vertex_array);
    glDeleteBuffers(2, mesh_buffers);
  }
}

Result<SplatProgram*> Renderer::State::splat_program(Pass pass, bool pulled, bool clipped) {
  SplatProgram& splat = splat_programs[pass][pulled][clipped];
  if (splat.program) return &splat;
  static constexpr int kKind[kPasses] = {KIND_QUAD, KIND_ELLIPSE, KIND_EXACT, KIND_BLENDED,
                                         KIND_BLENDED};
  std::string defines = "#define KIND " + std::to_string(kKind[pass]) + "\n";
  if (pulled) defines += "#define PULLED\n";
  if (clipped) defines += "#define CLIPPED\n";
  if (pass == pass_visibility) defines += "#define VISIBILITY\n";
  const std::initializer_list<std::string_view> vertex = {"frame.glsl", "surface_pixel.glsl",
                                                          "cell.glsl", "splat.vert.glsl"};
  Result<GlProgram> linked;
  if (pass == pass_quad) {
    linked = GlProgram::link(defines, vertex, {"quad.frag.glsl"});
  } else if (pass == pass_ellipse) {
    linked =
        GlProgram::link(defines, vertex, {"frame.glsl", "surface_pixel.glsl", "ellipse.frag.glsl"});
  } else {
    linked = GlProgram::link(defines, vertex,
                             {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "ray.glsl",
                              "cubic.glsl", "ray_cast.frag.glsl"});
  }
  if (!linked) return tl::unexpected(linked.error());
  splat.program = std::move(*linked);
  const GlProgram& program = splat.program;
  glUniformBlockBinding(program.name(), glGetUniformBlockIndex(program.name(), "Frame"),
                        kFrameBinding);
  splat.block = program.uniform("u_block");
  splat.isocode = program.uniform("u_isocode");
  splat.isosurface = program.uniform("u_isosurface");
  splat.scalar = program.uniform("u_scalar");
  splat.regions = program.uniform("u_regions");
  if (pulled) {
    glUseProgram(program.name());
    glUniform1i(program.uniform("u_samples"), 0);
  }
  return &splat;
}

/// Visible chunks inside the frustum and the clip planes, the nearest first.
void Renderer::State::collect_items(const Frame& frame) {
  items.clear();
  const auto& lens = frame.block().lens;
  for (const auto& [id, regions] : visible) {
    const auto found = chunks.find(id);
    if (found == chunks.end() || found->second.range.count == 0) continue;
    const Chunk& chunk = found->second;
    const Frame::Box box = frame.box(chunk.low, chunk.high);
    if (!frame.may_see(box)) {
      ++statistics.chunks_culled;
      continue;
    }
    const double level_scale = std::ldexp(1.0, static_cast<int>(chunk.block.level));
    const double nearest = frame.nearest(box);
    const auto& s = frame.block().spacing;
    const double diagonal = level_scale * length(Vec3d{s[0], s[1], s[2]});
    // Oblique cells near the image's corners look larger than their diagonal.
    const double largest_px = 1.5 * diagonal * double(lens[0]) * double(lens[3]) /
                              std::max(nearest - diagonal, double(frame.block().depth[2]));
    const Vec3d corner = box.centre - box.half;
    items.push_back({&chunk,
                     nearest,
                     {static_cast<float>(corner.x), static_cast<float>(corner.y),
                      static_cast<float>(corner.z), static_cast<float>(level_scale)},
                     {static_cast<GLuint>(regions), static_cast<GLuint>(regions >> 32)},
                     static_cast<float>(largest_px)});
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

Result<void> Renderer::State::draw_splats(Pass pass, const Frame& frame, int isosurface) {
  const Isosurface& surface = settings.isosurfaces[static_cast<size_t>(isosurface)];
  const float isocode = mapping.isocode(surface.isovalue);
  const int width = targets.width(), height = targets.height();
  // Points whose centres are outside of the image are not drawn, however large: so the viewport is
  // larger than the image.
  const auto guard = static_cast<GLint>(limits.guard_px);
  const SplatProgram* current = nullptr;
  uint32_t level = ~0u, buffer = ~0u;
  for (const DrawItem& item : items) {
    const Chunk& chunk = *item.chunk;
    if (!is_active(chunk.interval, isocode)) continue;
    const bool pulled = item.largest_px > limits.offered.max_point_size;
    const bool large = settings.projected && item.largest_px > float(LARGE_SPLAT_PX);
    const Pass chosen = large && (pass == pass_quad || pass == pass_ellipse) ? pass_exact : pass;
    const auto program = splat_program(chosen, pulled, frame.clipped());
    if (!program) return tl::unexpected(program.error());
    if (*program != current) {
      current = *program;
      glUseProgram(current->program.name());
      glUniform1f(current->isocode, isocode);
      glUniform1ui(current->isosurface, static_cast<GLuint>(isosurface));
      level = buffer = ~0u;
      if (pulled) {
        glViewport(0, 0, width, height);
        glBindVertexArray(empty_vertex_array);
      } else {
        glViewport(-guard, -guard, width + 2 * guard, height + 2 * guard);
      }
    }
    if (chunk.block.level != level) {
      level = chunk.block.level;
      glUniform3fv(current->scalar, 1, scalar_weights(frame, surface, level).data());
    }
    glUniform4fv(current->block, 1, item.block.data());
    glUniform2uiv(current->regions, 1, item.regions.data());
    const auto count = static_cast<GLsizei>(chunk.range.count);
    if (pulled) {
      load_samples(chunk.range);
      glDrawArrays(GL_TRIANGLES, 0, 6 * count);
    } else {
      if (chunk.range.buffer != buffer) {
        buffer = chunk.range.buffer;
        glBindVertexArray(buffers.vertex_array(buffer));
      }
      glDrawArrays(GL_POINTS, static_cast<GLint>(chunk.range.first), count);
    }
    ++statistics.draw_calls;
    if (pass != pass_accumulate) {
      statistics.samples_drawn += chunk.range.count;
      ++statistics.chunks_drawn;
    }
  }
  return {};
}

Result<void> Renderer::State::draw_isosurface(SplatKind kind, const Frame& frame, int isosurface,
                                              int layer) {
  if (kind != SplatKind::blended) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
    return draw_splats(kind == SplatKind::quad      ? pass_quad
                       : kind == SplatKind::ellipse ? pass_ellipse
                                                    : pass_exact,
                       frame, isosurface);
  }
  const float zero[4] = {0, 0, 0, 0}, one = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sums_framebuffer());
  glClearBufferfv(GL_COLOR, 0, zero);
  glClearBufferfv(GL_COLOR, 1, zero);
  glClearBufferfv(GL_DEPTH, 0, &one);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  if (auto ok = draw_splats(pass_visibility, frame, isosurface); !ok) return ok;
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glBlendEquationSeparate(GL_FUNC_ADD, GL_MAX);
  if (auto ok = draw_splats(pass_accumulate, frame, isosurface); !ok) return ok;
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);

  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram(normalise_program.name());
  glUniform1ui(normalise_program.uniform("u_isosurface"), static_cast<GLuint>(isosurface));
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
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(0));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram(mesh_program.name());
  glUniformMatrix4fv(mesh_program.uniform("u_clip_from_world"), 1, GL_FALSE,
                     frame.mesh_clip().data());
  glUniformMatrix3fv(mesh_program.uniform("u_view_from_world"), 1, GL_FALSE,
                     frame.mesh_view().data());
  glBindVertexArray(mesh_vertex_array);
  glDrawElements(GL_TRIANGLES, mesh_indices, GL_UNSIGNED_INT, nullptr);
  ++statistics.draw_calls;
  return {};
}

void Renderer::State::load_colour_map() {
  const int wanted = std::clamp(static_cast<int>(settings.colour_map), 0, kColourMaps - 1);
  glActiveTexture(GL_TEXTURE2);
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

Result<FrameStatistics> Renderer::State::draw(int width, int height, GLuint framebuffer) {
  statistics = FrameStatistics{};
  SplatKind kind = settings.kind;
  if (kind == SplatKind::blended && !limits.offered.float_targets) kind = SplatKind::ellipse;
  statistics.kind = kind;

  const int surfaces =
      static_cast<int>(std::min<size_t>(settings.isosurfaces.size(), kMaxIsosurfaces));
  // Layer 0 for what is opaque (or for nothing), one more for each translucent isosurface.
  int layer_of[kMaxIsosurfaces], layers = 1;
  for (int i = 0; i < surfaces; ++i) {
    const float opacity = settings.isosurfaces[static_cast<size_t>(i)].opacity;
    layer_of[i] = opacity <= 0 ? -1 : opacity >= kOpaque ? 0 : layers++;
  }
  if (auto ok = targets.prepare(width, height, layers, kind == SplatKind::blended,
                                limits.offered.float_blend);
      !ok) {
    return tl::unexpected(ok.error());
  }

  static const VolumeGrid kNoVolume{{2, 2, 2}};
  const Frame frame(grid ? *grid : kNoVolume, settings, camera, width, height, limits.guard_px,
                    limits.offered.max_point_size);
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
  for (int layer = 0; layer < layers; ++layer) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
    glClearBufferuiv(GL_COLOR, 0, nothing);
    glClearBufferfv(GL_DEPTH, 0, &farthest);
  }
  if (mesh_indices) {
    if (auto ok = draw_mesh(frame); !ok) return tl::unexpected(ok.error());
  } else {
    for (int i = 0; i < surfaces; ++i) {
      if (layer_of[i] < 0) continue;
      if (auto ok = draw_isosurface(kind, frame, i, layer_of[i]); !ok) {
        return tl::unexpected(ok.error());
      }
    }
  }

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  const GlProgram& compose_program = compose_programs[layers > 1];
  glUseProgram(compose_program.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.surfaces());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.depths());
  load_colour_map();
  if (layers > 1) glUniform1i(compose_program.uniform("u_layers"), layers);
  glUniform1i(compose_program.uniform("u_colour_by"), settings.colour_by == ColourBy::isosurface ? 0
                                                      : settings.colour_by == ColourBy::depth    ? 2
                                                                                              : 1);
  std::array<float, 4 * kMaxIsosurfaces> colours{};
  for (size_t i = 0; i < static_cast<size_t>(surfaces); ++i) {
    const Isosurface& surface = settings.isosurfaces[i];
    const Vec3f linear = to_linear(surface.colour);
    const float opacity = surface.opacity >= kOpaque ? 1.0f : surface.opacity;
    std::copy_n(std::array{linear.x, linear.y, linear.z, opacity}.begin(), 4,
                colours.begin() + static_cast<std::ptrdiff_t>(4 * i));
  }
  glUniform4fv(compose_program.uniform("u_colour"), kMaxIsosurfaces, colours.data());
  const auto& b = settings.background;
  const Vec3f background = to_linear({b[0], b[1], b[2]});
  glUniform4f(compose_program.uniform("u_background"), background.x, background.y, background.z,
              std::clamp(b[3], 0.0f, 1.0f));
  glUniform4f(compose_program.uniform("u_light"), settings.ambient, settings.specular,
              settings.eye_dome, std::max(1.0f, static_cast<float>(height) / 700));
  glBindVertexArray(empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  // Bound textures that are drawn into later would be a feedback loop.
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  ++statistics.draw_calls;

#ifndef NDEBUG
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return fail(Status::gl_error, "OpenGL reports error " + std::to_string(error) +
                                      " after a frame: a bug in the renderer or the driver");
  }
#endif
  statistics.samples_resident = buffers.samples();
  statistics.gpu_bytes =
      buffers.bytes() + targets.bytes() + mesh_bytes +
      uint64_t(sample_texture_rows) * SAMPLE_TEXTURE_WIDTH * sizeof(PackedSample);
  drawn_width = width;
  drawn_height = height;
  dirty = false;
  return statistics;
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() {
  if (state_->lost) {
    state_->forget_gl_objects();
  } else {
    state_->release_gl_objects();
  }
}

Result<std::unique_ptr<Renderer>> Renderer::create(float max_point_size) {
  auto state = std::make_unique<State>();
  state->max_point_size = max_point_size;
  if (auto ok = state->make_gl_objects(); !ok) return tl::unexpected(ok.error());
  return std::unique_ptr<Renderer>(new Renderer(std::move(state)));
}

const RendererLimits& Renderer::limits() const {
  return state_->limits.offered;
}

void Renderer::set_volume(const VolumeGrid& grid, const ValueMapping& mapping) {
  state_->grid = grid;
  state_->mapping = mapping;
  for (const auto& [id, chunk] : state_->chunks) state_->buffers.remove(chunk.range);
  state_->chunks.clear();
  state_->visible.clear();
  state_->dirty = true;
}

Result<void> Renderer::add_chunk(uint64_t id, ChunkPlace place,
                                 std::span<const PackedSample> samples) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost: add the chunk again later");
  if (!s.grid) return fail(Status::invalid_argument, "a chunk was added before any volume was set");
  const BlockKey& block = place.block;
  if (block.level >= level_count(s.grid->voxels)) {
    return fail(Status::invalid_argument,
                "a chunk's level " + std::to_string(block.level) + " is not one of the volume's");
  }
  const LevelGrid level = level_grid(s.grid->voxels, block.level);
  const Index3 at = block.index;
  if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= level.blocks.x || at.y >= level.blocks.y ||
      at.z >= level.blocks.z) {
    return fail(Status::invalid_argument, "a chunk's block lies outside of the volume");
  }
  remove_chunk(id);
  const auto range = s.buffers.add(samples);
  if (!range) return tl::unexpected(range.error());

  Chunk chunk{*range, block, {kMissingCode, 0}, {}, {}};
  for (const PackedSample& sample : samples) {
    chunk.interval.min = std::min(chunk.interval.min, static_cast<Code>(sample.word[1] & 0xffff));
    chunk.interval.max = std::max(chunk.interval.max, static_cast<Code>(sample.word[1] >> 16));
  }
  const double cell = std::ldexp(1.0, static_cast<int>(block.level));
  const Index3 cells = block_cells(level, at);
  chunk.low = Vec3d{double(at.x), double(at.y), double(at.z)} * (cell * kBlockCells);
  chunk.high = chunk.low + Vec3d{double(cells.x), double(cells.y), double(cells.z)} * cell;
  s.chunks.emplace(id, chunk);
  if (s.is_visible(id)) s.dirty = true;
  return {};
}

void Renderer::remove_chunk(uint64_t id) {
  State& s = *state_;
  const auto found = s.chunks.find(id);
  if (found == s.chunks.end()) return;
  s.buffers.remove(found->second.range);
  s.chunks.erase(found);
  if (s.is_visible(id)) s.dirty = true;
}

void Renderer::set_visible(std::span<const VisibleChunk> chunks) {
  const auto& visible = state_->visible;
  if (std::equal(chunks.begin(), chunks.end(), visible.begin(), visible.end())) return;
  state_->visible.assign(chunks.begin(), chunks.end());
  state_->dirty = true;
}

void Renderer::set_visible(std::span<const uint64_t> ids) {
  std::vector<VisibleChunk> chunks(ids.size());
  std::transform(ids.begin(), ids.end(), chunks.begin(),
                 [](uint64_t id) { return VisibleChunk{id}; });
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
  if (s.mesh_vertex_array) {
    glDeleteVertexArrays(1, &s.mesh_vertex_array);
    glDeleteBuffers(2, s.mesh_buffers);
  }
  s.mesh_vertex_array = 0;
  s.mesh_indices = 0;
  s.mesh_bytes = 0;
  s.dirty = true;
  if (triangles.empty()) return {};
  while (glGetError() != GL_NO_ERROR) {
  }
  glGenVertexArrays(1, &s.mesh_vertex_array);
  glGenBuffers(2, s.mesh_buffers);
  glBindVertexArray(s.mesh_vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, s.mesh_buffers[0]);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
               GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex), nullptr);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex),
                        reinterpret_cast<const void*>(sizeof(Vec3f)));
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, s.mesh_buffers[1]);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size_bytes()),
               triangles.data(), GL_STATIC_DRAW);
  glBindVertexArray(0);
  if (glGetError() != GL_NO_ERROR) {
    return fail(Status::out_of_memory, "the GPU has no room for the mesh");
  }
  s.mesh_indices = static_cast<GLsizei>(triangles.size());
  s.mesh_bytes = vertices.size_bytes() + triangles.size_bytes();
  return {};
}

bool Renderer::needs_redraw(int width, int height) const {
  const State& s = *state_;
  return !s.lost && (s.dirty || width != s.drawn_width || height != s.drawn_height);
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
  return state_->draw(width, height, framebuffer);
}

Result<std::vector<Renderer::SurfacePixel>> Renderer::read_surface() {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  if (s.drawn_width == 0) return fail(Status::invalid_argument, "nothing has been drawn yet");
  const int width = s.drawn_width, height = s.drawn_height;
  GLuint texture = 0, framebuffer = 0;
  glGenTextures(1, &texture);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, width, height);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram(s.read_program.name());
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
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteTextures(1, &texture);

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

void Renderer::context_lost() {
  state_->lost = true;
  state_->forget_gl_objects();
}

Result<void> Renderer::context_restored() {
  if (!state_->lost) return {};
  if (auto ok = state_->make_gl_objects(); !ok) return ok;
  state_->lost = false;
  return {};
}

}  // namespace isosplat
