#pragma once

#include <string>

namespace isosplat::cli {

/// Prints what a scene or a bundle holds: layers, stores, steps. Returns the exit code.
int print_scene(const std::string& path, bool as_json);

}  // namespace isosplat::cli
