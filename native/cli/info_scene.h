#pragma once

#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {

/// Prints what a scene or a bundle holds: layers, stores, steps. Returns the exit code.
int print_scene(const SceneFile& file, bool as_json);

}  // namespace isosplat::cli
