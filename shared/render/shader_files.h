#pragma once

#include <string_view>

namespace isosplat {

/// The text of a file in shared/render/shaders (or of shader_constants.h) by its name; empty where
/// there is none. Embedded at build time.
std::string_view shader_file(std::string_view name);

}  // namespace isosplat
