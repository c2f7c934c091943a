#pragma once

#include <string_view>

namespace isosplat::render {

/// The text of a file in shared/render/shaders (or of shader_constants.h) by its name, embedded at
/// build time. Empty if there is no such file.
std::string_view shader_file(std::string_view name);

}  // namespace isosplat::render
