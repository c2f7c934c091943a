#pragma once

#include "shared/core/base/status.h"
#include "shared/render/passes/accumulation.h"
#include "shared/render/passes/cross_fade.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/surface_pixel.h"

/// Passes over all pixels of an image. Each draws one triangle into a framebuffer, and leaves it
/// bound. Errors of all: gl_error, if a shader does not compile.
namespace isosplat::render {

/// Lights the surface pixels of `layers` layers, and blends them by depth. `still`: for
/// accumulation, with linear colours, ambient occlusion and shadows; else null.
Result<void> compose(const DrawContext& context, int layers, GLuint framebuffer,
                     const StillPicture* still);

/// Shows the picture that was lit while it was drawn (SurfaceTargets::picture), with eye-dome
/// lighting.
Result<void> show_lit_picture(const DrawContext& context, GLuint framebuffer);

/// Shows the mean of the accumulated pictures.
Result<void> present_mean(const DrawContext& context, const Accumulation& accumulation,
                          GLuint framebuffer);

/// Shows a mixture of two pictures: at 0 the first, at 1 the second.
Result<void> show_fade(const DrawContext& context, const CrossFade& cross_fade, float progress,
                       int width, int height, GLuint framebuffer);

/// Reads the surface pixels of layer 0, and waits for the GPU. `world_unit`: world units per unit
/// of frame space. Errors: gl_error also if the GPU has no room for the image.
Result<std::vector<SurfacePixel>> read_surface_pixels(const DrawContext& context, float world_unit);

}  // namespace isosplat::render
