#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/render/renderer_state.h"
#include "shared/render/shader_constants.h"

namespace isosplat {
namespace {

/// Image size beyond the edges for points whose centres lie outside: wider than any useful point.
constexpr float kMaxGuardPx = 512;

std::vector<std::string_view> extensions() {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::vector<std::string_view> names;
  for (GLint i = 0; i < count; ++i) {
    const auto* text =
        reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (!text) continue;
    std::string_view name = text;
    if (name.substr(0, 3) == "GL_") name.remove_prefix(3);  // WebGL names some both ways
    names.push_back(name);
  }
  return names;
}

GlLimits ask_limits(float largest_wanted) {
  GlLimits limits;
  GLfloat point_sizes[2] = {1, 1};
  glGetFloatv(GL_ALIASED_POINT_SIZE_RANGE, point_sizes);
  GLint viewport[2] = {0, 0};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limits.offered.max_texture_size);
  limits.offered.max_point_size = std::min({point_sizes[1], 2 * kMaxGuardPx, largest_wanted});
  const auto offered = extensions();
  const auto has_extension = [&](std::string_view name) {
    return std::find(offered.begin(), offered.end(), name) != offered.end();
  };
  limits.offered.float_targets = has_extension("EXT_color_buffer_float");
  limits.parallel_compile = has_extension("KHR_parallel_shader_compile");
  limits.multi_draw = has_extension("WEBGL_multi_draw");
  limits.offered.float_blend = has_extension("EXT_float_blend");
  if (const auto* text = reinterpret_cast<const char*>(glGetString(GL_RENDERER))) {
    limits.offered.renderer = text;
    limits.on_cpu = limits.offered.renderer.find("llvmpipe") != std::string::npos;
  }
  limits.guard_px = std::ceil(0.5f * limits.offered.max_point_size);
  return limits;
}

}  // namespace

Result<void> Renderer::State::make_gl_objects() {
  limits = ask_limits(max_point_size);
  lit = false;
  // What most first pictures are made with: the driver is at it while their samples arrive.
  start(image_programs[pass_compose + 2], pass_compose + 2);
  start_first_splat_programs();

  glGenBuffers(1, &frame_buffer);
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  glGenVertexArrays(1, &empty_vertex_array);
  glGenTextures(1, &colour_map);
  colour_map_loaded = -1;
  dirty = true;
  return {};
}

void Renderer::State::abandon_gl_objects() {
  chunks.clear();
  visible.clear();
  items.clear();
  buffers.abandon();
  targets.abandon();
  drawn_depths.abandon();
  depth_tiles.abandon();
  accumulation.abandon();
  cross_fade.abandon();
  occlusion_query.abandon();
  for_each_splat_program([](SplatProgram& splat) {
    splat.program.abandon();
    splat = SplatProgram{};
  });
  for (ImageProgram& image : image_programs) {
    image.program.abandon();
    image = ImageProgram{};
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
  drawn_depths.release();
  depth_tiles.release();
  accumulation.release();
  cross_fade.release();
  occlusion_query.release();
  for_each_splat_program([](SplatProgram& splat) { splat = SplatProgram{}; });
  for (ImageProgram& image : image_programs) image = ImageProgram{};
  glDeleteBuffers(1, &frame_buffer);
  glDeleteVertexArrays(1, &empty_vertex_array);
  glDeleteTextures(1, &colour_map);
  if (sample_texture) glDeleteTextures(1, &sample_texture);
  if (mesh_vertex_array) {
    glDeleteVertexArrays(1, &mesh_vertex_array);
    glDeleteBuffers(2, mesh_buffers);
  }
}

void Renderer::State::start_first_splat_programs() {
  const bool was_lit = std::exchange(lit, false);
  for (const Pass pass : {pass_exact, pass_ellipse}) {
    start(splat_programs[pass][0][0][0], pass, /*pulled=*/false, /*clipped=*/false);
  }
  lit = was_lit;
}

/// Forgets the splat programs where they are not made for such a grid.
void Renderer::State::set_sheared(bool is_sheared) {
  if (is_sheared == sheared) return;
  sheared = is_sheared;
  if (lost) return;
  for_each_splat_program([](SplatProgram& splat) { splat = SplatProgram{}; });
  start_first_splat_programs();
}

void Renderer::State::start(SplatProgram& splat, Pass pass, bool pulled, bool clipped) {
  static constexpr int kKind[kPasses] = {KIND_QUAD, KIND_ELLIPSE, KIND_EXACT, KIND_BLENDED,
                                         KIND_BLENDED};
  std::string defines = "#define KIND " + std::to_string(kKind[pass]) + "\n";
  if (pulled) defines += "#define PULLED\n";
  if (clipped) defines += "#define CLIPPED\n";
  if (lit) defines += "#define LIT\n";
  if (sheared) defines += "#define SHEARED\n";
  if (pass == pass_visibility) defines += "#define VISIBILITY\n";
  const std::initializer_list<std::string_view> vertex = {"frame.glsl", "cell.glsl", "splat.glsl",
                                                          "splat.vert.glsl"};
  if (pass == pass_quad) {
    splat.program = GlProgram::start(defines,
                                     {"frame.glsl", "surface_pixel.glsl", "gamma.glsl",
                                      "light.glsl", "cell.glsl", "splat.glsl", "quad.vert.glsl"},
                                     {"gamma.glsl", "quad.frag.glsl"});
  } else if (pass == pass_ellipse) {
    splat.program = GlProgram::start(defines, vertex,
                                     {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "ray.glsl",
                                      "cubic.glsl", "ellipse.frag.glsl"});
  } else {
    splat.program =
        GlProgram::start(defines, vertex,
                         {"frame.glsl", "surface_pixel.glsl", "gamma.glsl", "light.glsl",
                          "cell.glsl", "ray.glsl", "cubic.glsl", "ray_cast.frag.glsl"});
  }
}

Result<Renderer::State::SplatProgram*> Renderer::State::splat_program(Pass pass, bool pulled,
                                                                      bool clipped) {
  SplatProgram& splat = splat_programs[pass][pulled][clipped][lit];
  if (splat.is_ready) return &splat;
  if (!splat.program) start(splat, pass, pulled, clipped);
  if (auto ok = splat.program.finish(); !ok) return tl::unexpected(ok.error());
  const GlProgram& program = splat.program;
  glUniformBlockBinding(program.name(), glGetUniformBlockIndex(program.name(), "Frame"),
                        kFrameBinding);
  splat.block = program.uniform("u_block");
  splat.quantized_isovalue = program.uniform("u_quantized_isovalue");
  splat.isosurface = program.uniform("u_isosurface");
  splat.scalar = program.uniform("u_scalar");
  splat.drops_hidden = program.uniform("u_drops_hidden");
  glUseProgram(program.name());
  if (lit) glUniform1i(program.uniform("u_colour_map"), 3);
  if (pulled) {
    glUniform1i(program.uniform("u_samples"), 0);
  } else {
    glUniform1i(program.uniform("u_drawn"), 1);
  }
  splat.is_ready = true;
  ++statistics.programs_linked;
  return &splat;
}

void Renderer::State::start(ImageProgram& image, int pass) {
  switch (pass) {
    case pass_normalise:
      image.program = GlProgram::start("", {"image.vert.glsl"},
                                       {"frame.glsl", "surface_pixel.glsl", "normalise.frag.glsl"});
      return;
    case pass_present:
      image.program =
          GlProgram::start("", {"image.vert.glsl"}, {"gamma.glsl", "present.frag.glsl"});
      return;
    case pass_darken:
      image.program = GlProgram::start(
          "", {"image.vert.glsl"},
          {"frame.glsl", "gamma.glsl", "light.glsl", "eye_dome.glsl", "darken.frag.glsl"});
      return;
    case pass_fade:
      image.program = GlProgram::start("", {"image.vert.glsl"}, {"fade.frag.glsl"});
      return;
    case pass_read:
      image.program = GlProgram::start("", {"image.vert.glsl"}, {"frame.glsl", "read.frag.glsl"});
      return;
    case pass_mesh:
    case pass_lit_mesh:
      image.program = GlProgram::start(pass == pass_lit_mesh ? "#define LIT\n" : "",
                                       {"frame.glsl", "gamma.glsl", "light.glsl", "mesh.vert.glsl"},
                                       {"surface_pixel.glsl", "mesh.frag.glsl"});
      return;
    default: {
      const int composes = pass - pass_compose;
      const std::string defines = std::string(composes & 1 ? "" : "#define ONE_LAYER\n") +
                                  (composes & 2 ? "#define EYE_DOME\n" : "");
      image.program = GlProgram::start(defines, {"image.vert.glsl"},
                                       {"frame.glsl", "surface_pixel.glsl", "gamma.glsl",
                                        "light.glsl", "eye_dome.glsl", "compose.frag.glsl"});
    }
  }
}

Result<const GlProgram*> Renderer::State::image_program(int pass) {
  ImageProgram& image = image_programs[pass];
  const GlProgram& program = image.program;
  if (image.is_ready) return &program;
  if (!program) start(image, pass);
  if (auto ok = image.program.finish(); !ok) return tl::unexpected(ok.error());
  const GLuint frame = glGetUniformBlockIndex(program.name(), "Frame");
  if (frame != GL_INVALID_INDEX) glUniformBlockBinding(program.name(), frame, kFrameBinding);
  glUseProgram(program.name());
  // A program has some of these; locations of the others are -1, and ignored.
  glUniform1i(program.uniform("u_normals"), 0);
  glUniform1i(program.uniform("u_sums"), pass == pass_normalise ? 1 : 0);
  glUniform1i(program.uniform("u_picture"), 0);
  glUniform1i(program.uniform("u_from"), 0);
  glUniform1i(program.uniform("u_to"), 1);
  glUniform1i(program.uniform("u_surfaces"), 0);
  glUniform1i(program.uniform("u_depths"), 1);
  glUniform1i(program.uniform("u_colour_map"), 3);
  image.is_ready = true;
  ++statistics.programs_linked;
  return &program;
}

Result<void> Renderer::State::warm_up(GLuint framebuffer) {
  const PackedSample inactive{};
  const auto added = buffers.add(std::span(&inactive, 1));
  if (!added) return tl::unexpected(added.error());
  const SampleRange range = *added;
  layers = 1;
  lit = false;
  auto done = targets.prepare(1, 1, layers, /*blended=*/false, limits.offered.float_blend);
  if (done) done = depth_tiles.prepare(1, 1);
  if (done) {
    glEnable(GL_DEPTH_TEST);
    glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_buffer);
    depth_tiles.take(targets.layer(0), empty_vertex_array);
    for (const Pass pass : {pass_exact, pass_ellipse}) {
      const auto splat = splat_program(pass, /*pulled=*/false, /*clipped=*/false);
      if (!splat) {
        done = tl::unexpected(splat.error());
        break;
      }
      glUseProgram((*splat)->program.name());
      glActiveTexture(GL_TEXTURE1);
      glBindTexture(GL_TEXTURE_2D, depth_tiles.texture());
      glBindVertexArray(buffers.vertex_array(range.buffer));
      glDrawArrays(GL_POINTS, static_cast<GLint>(range.first), 1);
    }
    if (done) done = compose(framebuffer, false);
  }
  buffers.remove(range);
  dirty = true;
  return done;
}

}  // namespace isosplat
