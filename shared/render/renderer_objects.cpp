#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "shared/render/renderer_state.h"
#include "shared/render/shader_constants.h"

namespace isosplat {
namespace {

/// Image size beyond the edges for points whose centres lie outside: wider than any useful point.
constexpr float kMaxGuardPx = 512;

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

GlLimits ask_limits(float largest_wanted) {
  GlLimits limits;
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

}  // namespace

Result<void> Renderer::State::make_gl_objects() {
  limits = ask_limits(max_point_size);
  auto normalise = GlProgram::link("", {"image.vert.glsl"},
                                   {"frame.glsl", "surface_pixel.glsl", "normalise.frag.glsl"});
  if (!normalise) return tl::unexpected(normalise.error());
  for (int i = 0; i < 4; ++i) {
    const std::string defines =
        std::string(i & 1 ? "" : "#define ONE_LAYER\n") + (i & 2 ? "#define EYE_DOME\n" : "");
    auto compose = GlProgram::link(
        defines, {"image.vert.glsl"},
        {"frame.glsl", "surface_pixel.glsl", "picture_code.glsl", "compose.frag.glsl"});
    if (!compose) return tl::unexpected(compose.error());
    compose_programs[i] = std::move(*compose);
  }
  auto present =
      GlProgram::link("", {"image.vert.glsl"}, {"picture_code.glsl", "present.frag.glsl"});
  if (!present) return tl::unexpected(present.error());
  auto read = GlProgram::link("", {"image.vert.glsl"}, {"frame.glsl", "read.frag.glsl"});
  if (!read) return tl::unexpected(read.error());
  auto mesh = GlProgram::link("", {"mesh.vert.glsl"}, {"surface_pixel.glsl", "mesh.frag.glsl"});
  if (!mesh) return tl::unexpected(mesh.error());
  normalise_program = std::move(*normalise);
  present_program = std::move(*present);
  read_program = std::move(*read);
  mesh_program = std::move(*mesh);
  for (const GlProgram* program : {&normalise_program, &compose_programs[0], &compose_programs[1],
                                   &compose_programs[2], &compose_programs[3], &read_program}) {
    glUseProgram(program->name());
    glUniformBlockBinding(program->name(), glGetUniformBlockIndex(program->name(), "Frame"),
                          kFrameBinding);
  }
  glUseProgram(normalise_program.name());
  glUniform1i(normalise_program.uniform("u_normals"), 0);
  glUniform1i(normalise_program.uniform("u_sums"), 1);
  glUseProgram(present_program.name());
  glUniform1i(present_program.uniform("u_sums"), 0);
  for (const GlProgram* program : {&compose_programs[0], &compose_programs[1], &compose_programs[2],
                                   &compose_programs[3], &read_program}) {
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
  depth_tiles.forget();
  accumulation.forget();
  sight_test.forget();
  for (auto& pass : splat_programs) {
    for (auto& pulled : pass) {
      for (auto& program : pulled) {
        program.program.forget();
        program = SplatProgram{};
      }
    }
  }
  for (GlProgram& program : compose_programs) program.forget();
  for (GlProgram* program : {&normalise_program, &present_program, &read_program, &mesh_program}) {
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
  depth_tiles.release();
  accumulation.release();
  sight_test.release();
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

Result<Renderer::State::SplatProgram*> Renderer::State::splat_program(Pass pass, bool pulled,
                                                                      bool clipped) {
  SplatProgram& splat = splat_programs[pass][pulled][clipped];
  if (splat.program) return &splat;
  static constexpr int kKind[kPasses] = {KIND_QUAD, KIND_ELLIPSE, KIND_EXACT, KIND_BLENDED,
                                         KIND_BLENDED};
  std::string defines = "#define KIND " + std::to_string(kKind[pass]) + "\n";
  if (pulled) defines += "#define PULLED\n";
  if (clipped) defines += "#define CLIPPED\n";
  if (pass == pass_visibility) defines += "#define VISIBILITY\n";
  const std::initializer_list<std::string_view> vertex = {"frame.glsl", "cell.glsl", "regions.glsl",
                                                          "splat.glsl", "splat.vert.glsl"};
  Result<GlProgram> linked;
  if (pass == pass_quad) {
    linked = GlProgram::link(defines,
                             {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "regions.glsl",
                              "splat.glsl", "quad.vert.glsl"},
                             {"quad.frag.glsl"});
  } else if (pass == pass_ellipse) {
    linked = GlProgram::link(
        defines, vertex,
        {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "cubic.glsl", "ellipse.frag.glsl"});
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
  glUseProgram(program.name());
  if (pulled) {
    glUniform1i(program.uniform("u_samples"), 0);
  } else {
    glUniform1i(program.uniform("u_farthest"), 1);
  }
  return &splat;
}

}  // namespace isosplat
