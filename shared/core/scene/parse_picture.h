#pragma once

#include "shared/core/scene/scene.h"
#include "shared/core/scene/scene_member.h"

namespace isosplat {

/// Reads the members of a scene that concern its picture: camera, clipping, slices, look,
/// background and measurements. Faults are those of SceneMember.
void read_picture(const SceneMember& root, Scene& scene);

}  // namespace isosplat
