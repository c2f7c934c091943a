#pragma once

#include "native/headless/image.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// Draws a picture with the renderer's current scene and camera. An OpenGL context must be current.
/// `statistics` may be null. `smooth`: whether to antialias the picture (Renderer::refine). Large
/// images are drawn in tiles (Renderer::begin_tiles); their samples are counted in each tile.
/// Errors: as Renderer::draw.
Result<Image> draw_image(render::Renderer& renderer, int width, int height,
                         render::FrameStatistics* statistics = nullptr, bool smooth = false);

}  // namespace isosplat
