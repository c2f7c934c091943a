#include "shared/render/passes/lighting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "shared/core/base/matrix3.h"
#include "shared/render/passes/accumulation.h"
#include "shared/render/settings/colour_maps.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {

namespace {

static_assert(int(STILL_PICTURES) == Accumulation::kPictures);

void set(const GlProgram& program, const char* name, Vec3f v) {
  glUniform3f(program.uniform(name), v.x, v.y, v.z);
}

void set(const GlProgram& program, const char* name, float number) {
  glUniform1f(program.uniform(name), number);
}

bool shows_values(const RenderSettings& settings) {
  return settings.colour_by != ColourBy::isosurface;
}

}  // namespace

double visible_radius(const VolumeGrid& grid, const RenderSettings& settings) {
  const Vec3d low = settings.clip_box_low, high = settings.clip_box_high;
  const auto cells = [](int32_t voxels, double from, double to) {
    return (voxels - 1) * std::clamp(to - from, 0.01, 1.0);
  };
  const Vec3d shown{cells(grid.voxels.x, low.x, high.x), cells(grid.voxels.y, low.y, high.y),
                    cells(grid.voxels.z, low.z, high.z)};
  return 0.5 * longest_diagonal(scale_columns(grid.cell_edges(), shown));
}

void Lighting::bind_colour_map(const RenderSettings& settings) {
  const int index = std::clamp(static_cast<int>(settings.colour_map), 0, kColourMaps - 1);
  if (!colour_map_) glGenTextures(1, &colour_map_);
  glActiveTexture(GL_TEXTURE3);
  glBindTexture(GL_TEXTURE_2D, colour_map_);
  std::span<const std::array<uint8_t, 3>> categories;
  if (field_style(settings) == FieldStyle::categories) categories = settings.field_categories;
  categories = categories.first(std::min(categories.size(), kMaxCategoryColours));
  if (index == loaded_map_ && std::equal(categories.begin(), categories.end(),
                                         loaded_categories_.begin(), loaded_categories_.end())) {
    return;
  }
  loaded_categories_.assign(categories.begin(), categories.end());
  const size_t rows = 1 + (categories.size() + 255) / 256;
  std::vector<std::array<uint8_t, 3>> texels(256 * rows);
  std::memcpy(texels.data(), kColourMapTable[index], sizeof kColourMapTable[index]);
  std::copy(categories.begin(), categories.end(), texels.begin() + 256);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, 256, static_cast<GLsizei>(rows), 0, GL_RGB,
               GL_UNSIGNED_BYTE, texels.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  loaded_map_ = index;
}

void Lighting::bind_colours(std::span<const float> rgba) {
  if (!colours_) glGenTextures(1, &colours_);
  glActiveTexture(GL_TEXTURE4);
  glBindTexture(GL_TEXTURE_2D, colours_);
  if (std::equal(rgba.begin(), rgba.end(), loaded_colours_.begin(), loaded_colours_.end())) return;
  loaded_colours_.assign(rgba.begin(), rgba.end());
  const size_t rows = (rgba.size() / 4 + COLOURS_WIDTH - 1) / COLOURS_WIDTH;
  std::vector<float> texels(loaded_colours_);
  texels.resize(4 * COLOURS_WIDTH * rows);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, COLOURS_WIDTH, static_cast<GLsizei>(rows), 0, GL_RGBA,
               GL_FLOAT, texels.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void Lighting::apply(const GlProgram& program, const RenderSettings& settings,
                     std::span<const Isosurface> isosurfaces) {
  bind_colour_map(settings);
  // Programs that show fields take their colours from values. Other surfaces have their own
  // colours.
  glUniform1i(program.uniform("u_colour_by"),
              settings.colour_by == ColourBy::isosurface || settings.colour_by == ColourBy::field
                  ? 0
              : settings.colour_by == ColourBy::depth ? 2
                                                      : 1);
  set(program, "u_missing_colour", to_linear(settings.field_missing_colour));
  set(program, "u_field_steps",
      settings.field_steps >= 2 ? static_cast<float>(settings.field_steps) : 0.0f);
  glUniform1i(program.uniform("u_cap_colour_by"), settings.colour_by == ColourBy::isovalue ? 1
                                                  : settings.colour_by == ColourBy::depth  ? 2
                                                                                           : 0);
  std::vector<float> colours;
  for (const Isosurface& surface : isosurfaces) {
    const Vec3f linear = to_linear(surface.colour);
    const float opacity = surface.opacity >= kOpaque ? 1.0f : surface.opacity;
    colours.insert(colours.end(), {linear.x, linear.y, linear.z, opacity});
  }
  if (isosurfaces.size() > size_t{kMaxIsosurfaces}) {
    bind_colours(colours);
  } else {
    colours.resize(4 * kMaxIsosurfaces);
    glUniform4fv(program.uniform("u_colour"), kMaxIsosurfaces, colours.data());
  }

  const LightTerms terms = light_terms(settings.light, shows_values(settings));
  set(program, "u_key_direction", terms.key_direction);
  set(program, "u_roughness_4", terms.roughness_4);
  set(program, "u_key", terms.key);
  glUniform3fv(program.uniform("u_sky"), 3, &terms.sky[0].x);
  set(program, "u_rim_direction", terms.rim_direction);
  set(program, "u_rim_strength", terms.rim);
  set(program, "u_highlight_strength", terms.highlight);
  set(program, "u_least_light", terms.least);
  set(program, "u_most_light", terms.most);
}

void Lighting::apply_edges(const GlProgram& program, const RenderSettings& settings,
                           int image_height) {
  // Where colours stand for values, edge shading stops at kLeastEdgeShading.
  const float most = shows_values(settings) ? -std::log2(kLeastEdgeShading) /
                                                  float(EDGE_SHADING_SLOPE * EDGE_SHADING_MOST)
                                            : 1.0f;
  // The radius grows with the image: 1 px up to a height of 700 px.
  set(program, "u_edge_strength", std::min(settings.eye_dome, most));
  set(program, "u_edge_radius_px", std::max(1.0f, static_cast<float>(image_height) / 700));
}

bool Lighting::has_occlusion(const LightSettings& light) {
  return light.occlusion > 0 || light.shadow > 0;
}

void Lighting::apply_occlusion(const GlProgram& program, const LightSettings& light,
                               const StillPicture& picture) {
  // In close-ups, occluders reach over a fifth of the image's height, so that folds are visible
  // there.
  constexpr float kMostOfImage = 0.2f;
  const float radius = limited(light.occlusion_radius, 0.001f, 1) * picture.scene_radius;
  set(program, "u_ambient_strength", limited(light.occlusion, 0, 1));
  set(program, "u_ambient_radius", radius);
  set(program, "u_ambient_radius_per_distance", kMostOfImage * picture.image_height);
  // Shadows reach as far as the visible part's radius, or half of the image.
  set(program, "u_shadow_strength", limited(light.shadow, 0, 1));
  set(program, "u_light_radius", limited(light.shadow_softness, 0.01f, 0.5f));
  set(program, "u_shadow_length", picture.scene_radius);
  set(program, "u_shadow_length_per_distance", 0.5f * picture.image_height);
  // The same sequence as that of the offsets in the image, with another phase, and points of the
  // disc by H. Vogel's spiral (1979).
  const ImageOffset noise = Accumulation::offset(picture.index);
  constexpr float kGoldenAngle = 2.39996323f;
  const float index = static_cast<float>(picture.index);
  const float from_middle = std::sqrt((index + 0.5f) / float(Accumulation::kPictures));
  glUniform2f(program.uniform("u_noise_offset"), static_cast<float>(noise.right) + 0.5f,
              static_cast<float>(noise.up) + 0.5f);
  glUniform2f(program.uniform("u_point_in_light"), from_middle * std::cos(kGoldenAngle * index),
              from_middle * std::sin(kGoldenAngle * index));
}

void Lighting::release() {
  if (colour_map_) glDeleteTextures(1, &colour_map_);
  if (colours_) glDeleteTextures(1, &colours_);
  abandon();
}

void Lighting::abandon() {
  colour_map_ = colours_ = 0;
  loaded_map_ = -1;
  loaded_categories_.clear();
  loaded_colours_.clear();
}

}  // namespace isosplat::render
