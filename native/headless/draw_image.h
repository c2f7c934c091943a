#pragma once

#include "native/headless/image.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// Draws the renderer's current view into a picture. A context must be current.
/// Errors: as Renderer::draw. `statistics` may be null. `smooth`: refines it as far as possible.
Result<Image> draw_image(Renderer& renderer, int width, int height,
                         FrameStatistics* statistics = nullptr, bool smooth = false);

}  // namespace isosplat
