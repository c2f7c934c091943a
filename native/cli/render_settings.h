#pragma once

#include <optional>

#include "native/cli/render_options.h"
#include "native/headless/scene_picture.h"
#include "shared/core/base/status.h"
#include "shared/core/scene/scene.h"
#include "shared/render/settings/camera.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::cli {

/// The settings of the renderer. The ends of the colour map are those of --range, or unset. Errors:
/// invalid_argument.
Result<render::RenderSettings> render_settings(const RenderCall& call);

/// Sets clipping, slices, look and background of a scene, except for what options state. The
/// isosurfaces are those of `settings`.
void apply_scene_settings(const RenderCall& call, const Scene& scene, const ScenePicture& picture,
                          render::RenderSettings& settings);

/// The camera of the first picture. `aspect`: width / height.
render::Camera render_camera(const RenderCall& call, const VolumeGrid& grid, double aspect);

}  // namespace isosplat::cli
