#include "shared/render/lighting.h"

#include <algorithm>
#include <array>

#include "shared/render/colour_maps.h"

namespace isosplat {

Vec3f to_linear(Vec3f colour) {
  const auto square = [](float v) { return std::clamp(v, 0.0f, 1.0f) * std::clamp(v, 0.0f, 1.0f); };
  return {square(colour.x), square(colour.y), square(colour.z)};
}

void Lighting::bind_colour_map(ColourMap map) {
  const int index = std::clamp(static_cast<int>(map), 0, kColourMaps - 1);
  if (!colour_map_) glGenTextures(1, &colour_map_);
  glActiveTexture(GL_TEXTURE3);
  glBindTexture(GL_TEXTURE_2D, colour_map_);
  if (index == loaded_map_) return;
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 256, 1, 0, GL_RGB, GL_UNSIGNED_BYTE,
               kColourMapTable[index]);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  loaded_map_ = index;
}

void Lighting::apply(const GlProgram& program, const RenderSettings& settings, int image_height) {
  bind_colour_map(settings.colour_map);
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
  // The radius of eye-dome lighting grows with the image: 1 px up to a height of 700 px.
  glUniform4f(program.uniform("u_light"), settings.ambient, settings.specular, settings.eye_dome,
              std::max(1.0f, static_cast<float>(image_height) / 700));
}

void Lighting::release() {
  if (colour_map_) glDeleteTextures(1, &colour_map_);
  abandon();
}

void Lighting::abandon() {
  colour_map_ = 0;
  loaded_map_ = -1;
}

}  // namespace isosplat
