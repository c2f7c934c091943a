#pragma once

#include <cstddef>
#include <cstdint>

/// The renderer for JavaScript: the exports of the module `isosplat-renderer`. One view per module
/// instance; call every function on the thread that owns the canvas. Memory that a function reads
/// is the caller's (malloc, free are exported); pointers need hold only during the call, and any
/// call may grow the heap, so re-read HEAPU8 after it. Functions that return int32_t return a
/// Status (0: ok); isosplat_renderer_error() then says what went wrong.
extern "C" {

/// Makes a WebGL 2 context on the canvas with this CSS selector (UTF-8, null-terminated) and the
/// renderer on it. antialias off, alpha on, premultiplied.
int32_t isosplat_renderer_create(const char* canvas_selector);
void isosplat_renderer_destroy();

/// Whether warm_up has nothing to wait for: Renderer::is_compiled.
int32_t isosplat_renderer_is_compiled();

/// Has the driver finish compiling before the first picture: Renderer::warm_up.
int32_t isosplat_renderer_warm_up();

/// The last error's message, UTF-8, null-terminated; valid until the next call.
const char* isosplat_renderer_error();

/// grid: voxels x y z, spacing x y z, origin x y z, direction row by row (9): 18 numbers.
/// mapping: offset, scale.
int32_t isosplat_renderer_set_volume(const double* grid, const double* mapping);

/// samples: count × 16 bytes, as a chunk decoder yields them (PackedSample). id: the caller's.
int32_t isosplat_renderer_add_chunk(uint32_t id, uint32_t level, int32_t block_x, int32_t block_y,
                                    int32_t block_z, const void* samples, uint32_t count);
/// What went wrong on the GPU since the last call: Renderer::check_gpu.
int32_t isosplat_renderer_check_gpu();
void isosplat_renderer_remove_chunk(uint32_t id);

/// Draws exactly these chunks from now on. regions: 16 words per id (RegionMask); null: all of
/// each.
void isosplat_renderer_set_visible(const uint32_t* ids, const uint32_t* regions, uint32_t count);

/// surfaces: count × (isovalue, red, green, blue, opacity), colours sRGB 0 … 1.
void isosplat_renderer_set_isosurfaces(const double* surfaces, uint32_t count);

/// SplatKind: 0 quad, 1 ellipse, 2 blended, 3 exact.
void isosplat_renderer_set_kind(int32_t kind);

/// ColourBy: 0 isosurface, 1 isovalue, 2 gradient, 3 depth, 4 level, 5 projection error.
/// ColourMap: 0 viridis, 1 magma, 2 cividis, 3 turbo. low, high: the range of values mapped.
void isosplat_renderer_set_colouring(int32_t colour_by, int32_t colour_map, double low,
                                     double high);

/// A ColourMap as 256 sRGB colours of 3 bytes, from low to high: for a legend. Null for a number
/// that is none. Valid for ever.
const uint8_t* isosplat_renderer_colour_map(int32_t colour_map);

/// Background sRGB and alpha, 0 … 1.
void isosplat_renderer_set_background(float red, float green, float blue, float alpha);
void isosplat_renderer_set_lighting(float ambient, float specular, float eye_dome);

/// box: low x y z, high x y z as fractions of the volume. planes: count × (normal x y z, offset).
void isosplat_renderer_set_clipping(const double* box, const double* planes, uint32_t count);

/// camera, here and below: target x y z, distance, azimuth, elevation, roll, field of view (8
/// numbers, see Camera). The functions that change one write it back to the same place.
void isosplat_renderer_set_camera(const double* camera);
/// aspect: the image's width / height.
void isosplat_renderer_default_camera(double* camera, double aspect);
void isosplat_renderer_orbit(double* camera, double right_degrees, double up_degrees);
void isosplat_renderer_pan(double* camera, double right_px, double down_px, double image_height_px);
void isosplat_renderer_zoom(double* camera, double factor);
/// A camera that can be drawn from: bounded() in shared/render/camera.h.
void isosplat_renderer_bound(double* camera);

/// What draw() will use for a picture of this size: clip space from world, 16 numbers, column by
/// column. For choosing what to fetch.
void isosplat_renderer_projection(const double* camera, int32_t width, int32_t height,
                                  double* clip_from_world);

/// 1 if a draw of this size would change the picture.
int32_t isosplat_renderer_needs_redraw(int32_t width, int32_t height);

/// Draws to the canvas, whose width and height in pixels these are. statistics (may be null)
/// receives 8 numbers: samples drawn, samples resident, GPU bytes, chunks drawn, chunks culled,
/// draw calls, kind drawn, programs linked.
int32_t isosplat_renderer_draw(int32_t width, int32_t height, double* statistics);

/// 1 if isosplat_renderer_refine would smooth the edges of the picture last drawn, of this size.
int32_t isosplat_renderer_can_refine(int32_t width, int32_t height);

/// Draws the still view once more, moved by a part of a pixel, and shows the mean. statistics as
/// above.
int32_t isosplat_renderer_refine(int32_t width, int32_t height, double* statistics);

/// Renderer::hold_picture, begin_fade (1: a fade has begun, 0: there is nothing to fade from,
/// negative: it failed) and fade.
int32_t isosplat_renderer_hold_picture();
int32_t isosplat_renderer_begin_fade();
int32_t isosplat_renderer_fade(float progress);

/// Starts a test of which regions of these chunks show in at least so many pixels
/// (Renderer::begin_occlusion_query); draw first.
int32_t isosplat_renderer_begin_occlusion_query(const uint32_t* ids, uint32_t count,
                                                int32_t min_px);

/// Chunks in the test's answer, or −1 while it is not there. It is at
/// isosplat_renderer_occlusion_answer() until the next call of this: 33 words per chunk: id, the
/// regions tested, those seen.
int32_t isosplat_renderer_take_occlusion_query();
const uint32_t* isosplat_renderer_occlusion_answer();

/// limits receives 4 numbers: largest point size, largest texture size, float targets (0, 1), float
/// blending (0, 1). Returns GL_RENDERER, valid until the next call.
const char* isosplat_renderer_limits(double* limits);

/// Call on the canvas's webglcontextlost (after preventDefault) and webglcontextrestored. All
/// chunks are gone: add them again after the latter.
void isosplat_renderer_context_lost();
int32_t isosplat_renderer_context_restored();
}
