#include "shared/render/gl/gl_limits.h"

#include <GLES3/gl3.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace isosplat::render {
namespace {

/// Upper limit of the guard band, wider than any useful point.
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
    // WebGL lists some extensions with this prefix and without it.
    if (name.substr(0, 3) == "GL_") name.remove_prefix(3);
    names.push_back(name);
  }
  return names;
}

}  // namespace

GlLimits query_gl_limits(float max_point_size) {
  GlLimits limits;
  GLfloat point_sizes[2] = {1, 1};
  glGetFloatv(GL_ALIASED_POINT_SIZE_RANGE, point_sizes);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limits.offered.max_texture_size);
  limits.offered.max_point_size = std::min({point_sizes[1], 2 * kMaxGuardPx, max_point_size});
  const auto offered = extensions();
  const auto has_extension = [&](std::string_view name) {
    return std::find(offered.begin(), offered.end(), name) != offered.end();
  };
  limits.offered.float_targets = has_extension("EXT_color_buffer_float");
  limits.offered.float_blend = has_extension("EXT_float_blend");
  limits.parallel_compile = has_extension("KHR_parallel_shader_compile");
  limits.multi_draw = has_extension("WEBGL_multi_draw");
  if (const auto* text = reinterpret_cast<const char*>(glGetString(GL_RENDERER))) {
    limits.offered.renderer = text;
    limits.on_cpu = limits.offered.renderer.find("llvmpipe") != std::string::npos;
  }
  limits.guard_px = std::ceil(0.5f * limits.offered.max_point_size);
  return limits;
}

}  // namespace isosplat::render
