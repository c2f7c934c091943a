#include "shared/render/passes/shader_programs.h"

#include <algorithm>
#include <string>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

constexpr std::string_view kNoFile;  // in place of a file that a program does not need

constexpr SplatPass kFirstSplatPasses[] = {SplatPass::exact, SplatPass::ellipse};

/// Indices of variants among those of a camera.
size_t index_of(const SplatVariant& variant) {
  return 64 * static_cast<size_t>(variant.pass) + 16 * static_cast<size_t>(variant.field) +
         (variant.smooth ? 8u : 0u) + (variant.pulled ? 4u : 0u) + (variant.clipped ? 2u : 0u) +
         (variant.lit ? 1u : 0u);
}

SplatVariant splat_variant(size_t index) {
  return {static_cast<SplatPass>(index / 64),
          (index & 4) != 0,
          (index & 2) != 0,
          (index & 1) != 0,
          (index & 8) != 0,
          static_cast<FieldStyle>(index / 16 % 4)};
}

std::string field_defines(FieldStyle style) {
  switch (style) {
    case FieldStyle::none:
      return {};
    case FieldStyle::values:
      break;
    case FieldStyle::lines:
      return "#define FIELD\n#define LINES\n";
    case FieldStyle::categories:
      return "#define FIELD\n#define CATEGORIES\n";
  }
  return "#define FIELD\n";
}

}  // namespace

ShaderPrograms::Splat& ShaderPrograms::slot(SplatVariant variant) {
  return current().splats[index_of(variant)];
}

void ShaderPrograms::start_first() {
  started_ = current().is_started = true;
  const ComposeVariant moving{.eye_dome = true};
  slot(moving).program = start(moving);
  start_splats();
}

void ShaderPrograms::start_splats() {
  for (const SplatPass pass : kFirstSplatPasses) slot({pass}).program = start({pass});
}

void ShaderPrograms::prepare(SplatVariant variant) {
  if (Splat& splat = slot(variant); !splat.program) splat.program = start(variant);
}

void ShaderPrograms::prepare(ImagePass pass) {
  if (Image& image = slot(pass); !image.program) image.program = start(pass);
}

void ShaderPrograms::prepare(ComposeVariant variant) {
  if (Image& image = slot(variant); !image.program) image.program = start(variant);
}

bool ShaderPrograms::is_compiled() const {
  const auto is_done = [](const auto& entry) {
    return !entry.program || entry.is_ready || entry.program.is_done();
  };
  const Set& set = current();
  return std::all_of(set.images.begin(), set.images.end(), is_done) &&
         std::all_of(set.composes.begin(), set.composes.end(), is_done) &&
         std::all_of(set.splats.begin(), set.splats.end(), is_done);
}

void ShaderPrograms::finish_started() {
  Set& set = current();
  for (size_t i = 0; i < set.splats.size(); ++i) {
    if (set.splats[i].program) (void)splat(splat_variant(i));
  }
  for (size_t i = 0; i < set.images.size(); ++i) {
    if (set.images[i].program) (void)image(static_cast<ImagePass>(i));
  }
  for (Image& compose : set.composes) {
    if (compose.program) (void)finish(compose);
  }
}

bool ShaderPrograms::Set::is_used() const {
  const auto is_ready = [](const auto& entry) { return entry.is_ready; };
  return std::any_of(images.begin(), images.end(), is_ready) ||
         std::any_of(composes.begin(), composes.end(), is_ready) ||
         std::any_of(splats.begin(), splats.end(), is_ready);
}

template <class Entries>
void ShaderPrograms::retire(Entries& entries) {
  for (auto& entry : entries) {
    if (entry.program && !entry.is_ready) retired_.push_back(std::move(entry.program));
    entry = {};
  }
}

void ShaderPrograms::set_sheared(bool sheared) {
  if (sheared == sheared_) return;
  sheared_ = sheared;
  if (!started_) return;
  for (Set& set : sets_) {
    retire(set.splats);
  }
  start_splats();
}

void ShaderPrograms::set_orthographic(bool orthographic) {
  if (orthographic == orthographic_) return;
  if (Set& set = current(); !set.is_used()) {
    retire(set.splats);
    retire(set.images);
    retire(set.composes);
    set.is_started = false;
  }
  orthographic_ = orthographic;
  if (started_ && !current().is_started) start_first();
}

GlProgram ShaderPrograms::start_image(
    std::string_view defines, std::initializer_list<std::string_view> fragment_files) const {
  std::string all(orthographic_ ? kOrthographicDefine : "");
  all += defines;
  return GlProgram::start(all, {"image.vert.glsl"}, fragment_files);
}

GlProgram ShaderPrograms::start(SplatVariant variant) const {
  static constexpr int kKind[kSplatPasses] = {KIND_QUAD,  KIND_ELLIPSE, KIND_EXACT, KIND_EXACT,
                                              KIND_EXACT, KIND_EXACT,   KIND_EXACT, KIND_EXACT};
  std::string defines =
      "#define KIND " + std::to_string(kKind[static_cast<size_t>(variant.pass)]) + "\n";
  if (variant.pulled) defines += "#define PULLED\n";
  if (variant.clipped) defines += "#define CLIPPED\n";
  if (variant.lit) defines += "#define LIT\n";
  if (variant.smooth) defines += "#define SMOOTH\n";
  defines += field_defines(variant.field);
  if (sheared_) defines += "#define SHEARED\n";
  if (orthographic_) defines += kOrthographicDefine;
  if (variant.pass == SplatPass::gradients) {
    return GlProgram::start(
        defines + "#define GRADIENTS\n",
        {"frame.glsl", "cell.glsl", "block.glsl", "splat.glsl", "gradients.vert.glsl"},
        {"frame.glsl", "smooth.glsl", "gradients.frag.glsl"});
  }
  if (variant.pass == SplatPass::lattice) {
    return GlProgram::start(defines, {"cell.glsl", "lattice.glsl", "lattice.vert.glsl"},
                            {"lattice.frag.glsl"});
  }
  if (variant.pass == SplatPass::cut_cells) {
    return GlProgram::start(defines,
                            {"frame.glsl", "cell.glsl", "crossings.glsl", "thin.glsl", "block.glsl",
                             "splat.glsl", "cut_cells.vert.glsl"},
                            {"frame.glsl", "cell.glsl", "entry.glsl", "cut_cells.frag.glsl"});
  }
  if (variant.pass == SplatPass::slice_cells) {
    return GlProgram::start(
        defines,
        {"frame.glsl", "cell.glsl", "crossings.glsl", "thin.glsl", "block.glsl", "splat.glsl",
         "slice.glsl", "slice_cells.vert.glsl"},
        {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "slice.glsl", "slice_cells.frag.glsl"});
  }
  const std::string_view field = variant.field != FieldStyle::none ? "field.glsl" : kNoFile;
  const std::string_view corners =
      variant.field != FieldStyle::none ? "field_corners.glsl" : kNoFile;
  const std::string_view coverage =
      variant.field == FieldStyle::lines ? "line_coverage.glsl" : kNoFile;
  const std::string_view lines = variant.field == FieldStyle::lines ? "field_lines.glsl" : kNoFile;
  if (variant.pass == SplatPass::triangles) {
    const auto if_field = [&](std::string_view file) { return field.empty() ? kNoFile : file; };
    return GlProgram::start(
        defines,
        {"frame.glsl", "gamma.glsl", "light.glsl", "cell.glsl", field, corners, "block.glsl",
         "lattice.glsl", "triangles.vert.glsl"},
        {"frame.glsl", "surface_pixel.glsl", if_field("gamma.glsl"), if_field("light.glsl"),
         if_field("cell.glsl"), field, coverage, lines, "triangles.frag.glsl"});
  }
  if (variant.pass == SplatPass::quad) {
    return GlProgram::start(defines,
                            {"frame.glsl", "surface_pixel.glsl", "gamma.glsl", "light.glsl",
                             "cell.glsl", "crossings.glsl", "thin.glsl", "block.glsl", "splat.glsl",
                             field, corners, coverage, lines, "quad.vert.glsl"},
                            {"gamma.glsl", coverage, "quad.frag.glsl"});
  }
  const std::initializer_list<std::string_view> vertex = {
      "frame.glsl", "cell.glsl", "crossings.glsl", "thin.glsl",      "block.glsl",
      "splat.glsl", field,       corners,          "splat.vert.glsl"};
  if (variant.pass == SplatPass::ellipse) {
    return GlProgram::start(defines, vertex,
                            {"frame.glsl", "surface_pixel.glsl", "cell.glsl", "ray.glsl",
                             "cubic.glsl", field, coverage, lines, "ellipse.frag.glsl"});
  }
  return GlProgram::start(
      defines, vertex,
      {"frame.glsl", "surface_pixel.glsl", "gamma.glsl", "light.glsl", "cell.glsl", "ray.glsl",
       "cubic.glsl", field, coverage, lines, "ray_cast.frag.glsl"});
}

Result<const ShaderPrograms::Splat*> ShaderPrograms::splat(SplatVariant variant) {
  prepare(variant);
  Splat& splat = slot(variant);
  if (splat.is_ready) return &splat;
  GlProgram& program = splat.program;
  if (auto ok = program.finish(); !ok) return tl::unexpected(ok.error());
  const GLuint frame = glGetUniformBlockIndex(program.name(), "Frame");
  if (frame != GL_INVALID_INDEX) glUniformBlockBinding(program.name(), frame, kFrameBinding);
  splat.block = program.uniform("u_block");
  splat.quantized_isovalue = program.uniform("u_quantized_isovalue");
  splat.isosurface = program.uniform("u_isosurface");
  splat.scalar = program.uniform("u_scalar");
  splat.field = program.uniform("u_field");
  splat.field_missing = program.uniform("u_field_missing");
  splat.lines = program.uniform("u_lines");
  splat.line_tones = program.uniform("u_line_tones");
  splat.drops_hidden = program.uniform("u_drops_hidden");
  splat.gradient_weight = program.uniform("u_gradient_weight");
  splat.finest_side_px = program.uniform("u_finest_side_px");
  splat.smooth_px = program.uniform("u_smooth_px");
  splat.per_cell = program.uniform("u_per_cell");
  glUseProgram(program.name());
  if (variant.lit) glUniform1i(program.uniform("u_colour_map"), 3);
  glUniform1i(program.uniform("u_positions"), 2);
  // Triangles have the colour map in unit 3.
  const bool is_lattice = variant.pass == SplatPass::lattice;
  glUniform1i(program.uniform("u_pages"), is_lattice ? 2 : 5);
  glUniform1i(program.uniform("u_gradients"), 6);
  if (variant.pass == SplatPass::triangles) glUniform1i(program.uniform("u_cases"), 2);
  if (variant.pulled) {
    glUniform1i(program.uniform("u_samples"), 0);
    glUniform1i(program.uniform("u_fields"), FIELD_TEXTURE_UNIT);
  }
  glUniform1i(program.uniform("u_drawn"), 1);
  splat.is_ready = true;
  ++linked_count_;
  return &splat;
}

GlProgram ShaderPrograms::start(ImagePass pass) const {
  switch (pass) {
    case ImagePass::positions:
      return start_image("", {"frame.glsl", "positions.frag.glsl"});
    case ImagePass::smooth_normals:
      return start_image("", {"frame.glsl", "surface_pixel.glsl", "smooth_normals.frag.glsl"});
    case ImagePass::lattice_normals:
      return start_image(
          "", {"frame.glsl", "surface_pixel.glsl", "lattice.glsl", "lattice_normals.frag.glsl"});
    case ImagePass::replace_normals:
      return start_image("", {"replace_normals.frag.glsl"});
    case ImagePass::present:
      return start_image("", {"gamma.glsl", "present.frag.glsl"});
    case ImagePass::darken:
      return start_image(
          "", {"frame.glsl", "gamma.glsl", "depths.glsl", "eye_dome.glsl", "darken.frag.glsl"});
    case ImagePass::fade:
      return start_image("", {"fade.frag.glsl"});
    case ImagePass::cap_states:
      return start_image(
          "", {"frame.glsl", "surface_pixel.glsl", "entry.glsl", "cap_states.frag.glsl"});
    case ImagePass::cap_tiles:
      return start_image("", {"cap_likely.glsl", "cap_tiles.frag.glsl"});
    case ImagePass::cap_jump:
      return start_image("", {"cap_jump.frag.glsl"});
    case ImagePass::caps:
      return start_image("", {"frame.glsl", "surface_pixel.glsl", "entry.glsl", "cap_likely.glsl",
                              "caps.frag.glsl"});
    case ImagePass::slice:
      return start_image("", {"frame.glsl", "surface_pixel.glsl", "slice.glsl", "slice.frag.glsl"});
    case ImagePass::read:
      return start_image("", {"frame.glsl", "read.frag.glsl"});
    case ImagePass::mesh:
    case ImagePass::lit_mesh:
      break;
  }
  std::string defines(orthographic_ ? kOrthographicDefine : "");
  if (pass == ImagePass::lit_mesh) defines += "#define LIT\n";
  return GlProgram::start(defines, {"frame.glsl", "gamma.glsl", "light.glsl", "mesh.vert.glsl"},
                          {"surface_pixel.glsl", "mesh.frag.glsl"});
}

GlProgram ShaderPrograms::start(ComposeVariant variant) const {
  std::string defines = variant.several_layers ? "" : "#define ONE_LAYER\n";
  if (variant.eye_dome) defines += "#define EYE_DOME\n";
  if (variant.many_surfaces) defines += "#define MANY_SURFACES\n";
  defines += field_defines(variant.field);
  if (!variant.still) {
    return start_image(defines, {"frame.glsl", "surface_pixel.glsl", "gamma.glsl", "light.glsl",
                                 "depths.glsl", "eye_dome.glsl", "compose.frag.glsl"});
  }
  if (variant.tile) defines += "#define TILE\n";
  return start_image(defines + "#define STILL\n",
                     {"frame.glsl", "surface_pixel.glsl", "gamma.glsl", "light.glsl", "depths.glsl",
                      "eye_dome.glsl", "occlusion.glsl", "compose.frag.glsl"});
}

Result<const GlProgram*> ShaderPrograms::image(ImagePass pass) {
  prepare(pass);
  Image& image = slot(pass);
  const bool was_ready = image.is_ready;
  auto finished = finish(image);
  if (finished && !was_ready) {
    glUniform1i(image.program.uniform("u_sums"), pass == ImagePass::smooth_normals ? 1 : 0);
  }
  return finished;
}

Result<const GlProgram*> ShaderPrograms::compose(ComposeVariant variant) {
  prepare(variant);
  return finish(slot(variant));
}

Result<const GlProgram*> ShaderPrograms::finish(Image& image) {
  GlProgram& program = image.program;
  if (image.is_ready) return &program;
  if (auto ok = program.finish(); !ok) return tl::unexpected(ok.error());
  const GLuint frame = glGetUniformBlockIndex(program.name(), "Frame");
  if (frame != GL_INVALID_INDEX) glUniformBlockBinding(program.name(), frame, kFrameBinding);
  glUseProgram(program.name());
  // No program has all of these. GL ignores location -1.
  glUniform1i(program.uniform("u_positions"), 0);
  glUniform1i(program.uniform("u_picture"), 0);
  glUniform1i(program.uniform("u_from"), 0);
  glUniform1i(program.uniform("u_to"), 1);
  glUniform1i(program.uniform("u_surfaces"), 0);
  glUniform1i(program.uniform("u_depths"), 1);
  glUniform1i(program.uniform("u_whole_depths"), 2);
  glUniform1i(program.uniform("u_normals"), 0);
  glUniform1i(program.uniform("u_pages"), 2);
  glUniform1i(program.uniform("u_gradients"), 3);
  glUniform1i(program.uniform("u_colour_map"), 3);
  glUniform1i(program.uniform("u_colours"), 4);
  glUniform1i(program.uniform("u_cut_cells"), 4);
  glUniform1i(program.uniform("u_states"), 5);
  glUniform1i(program.uniform("u_tiles"), 6);
  glUniform1i(program.uniform("u_nearest"), 7);
  image.is_ready = true;
  ++linked_count_;
  return &program;
}

void ShaderPrograms::Set::abandon() {
  // One by one: a temporary set would fill half of a browser's stack.
  const auto abandon_all = [](auto& entries) {
    for (auto& entry : entries) {
      entry.program.abandon();
      entry = {};
    }
  };
  abandon_all(splats);
  abandon_all(images);
  abandon_all(composes);
  is_started = false;
}

void set_isosurfaces(const GlProgram& program, std::span<const int> isosurfaces) {
  std::array<GLint, MAX_ISOSURFACES> numbers;
  numbers.fill(-1);
  std::copy_n(isosurfaces.begin(), std::min<size_t>(isosurfaces.size(), MAX_ISOSURFACES),
              numbers.begin());
  glUniform1iv(program.uniform("u_isosurfaces"), MAX_ISOSURFACES, numbers.data());
}

void ShaderPrograms::abandon() {
  started_ = false;
  for (Set& set : sets_) set.abandon();
  for (GlProgram& program : retired_) program.abandon();
  retired_.clear();
}

}  // namespace isosplat::render
