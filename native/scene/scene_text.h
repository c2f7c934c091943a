#pragma once

#include <string>

#include "shared/core/scene/scene.h"

namespace isosplat {

/// The document of a scene (SCENE.md), which parse_scene() reads as an equal scene. Members with
/// their default value are left out.
std::string scene_text(const Scene& scene);

}  // namespace isosplat
