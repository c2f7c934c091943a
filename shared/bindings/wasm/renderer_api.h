#pragma once

#include <cstdint>

#include "shared/bindings/wasm/core_api.h"

/// The renderer for JavaScript: exported by the module `isosplat-renderer`, beside the functions of
/// core_api.h. web/viewer/renderer_module.ts wraps it.
///
/// Rules:
/// - A module instance has one renderer, on one canvas. Call every function on the thread that owns
///   the canvas.
/// - A function that can fail returns an IsosplatStatus, and never anything else: 0 is ok, any
///   other number is a Status. After a failure isosplat_renderer_error() returns the message.
///   Before isosplat_renderer_create such functions return invalid_argument, and others do nothing.
/// - Values are returned through pointers to records (records.h). After a failure the record is
///   unchanged.
/// - Functions that return a bool have no errors.
/// - Memory that a function reads belongs to the caller (malloc and free are exported). The
///   function does not keep pointers to it.
/// - `volume` is the number of a volume, which the caller chooses: Renderer::set_volume.
/// - Every call may grow the heap: read memory.buffer again after it.
extern "C" {

/// Creates a WebGL 2 context on the canvas with this CSS selector (UTF-8, null-terminated), and the
/// renderer. The context has premultiplied alpha and no antialiasing.
IsosplatStatus isosplat_renderer_create(const char* canvas_selector);
void isosplat_renderer_destroy();

/// Renderer::is_compiled: warm_up would not wait for the driver's compiler.
bool isosplat_renderer_is_compiled();

/// Renderer::warm_up: finishes the compilation before the first picture.
IsosplatStatus isosplat_renderer_warm_up();

/// The message of the last error, UTF-8, null-terminated. It is valid until the next call.
const char* isosplat_renderer_error();

/// Renderer::set_volume, move_volume and remove_volume. remove_volume also removes the isosurfaces
/// of the volume.
IsosplatStatus isosplat_renderer_set_volume(uint32_t volume, const IsosplatVolume* record);
IsosplatStatus isosplat_renderer_move_volume(uint32_t volume, const IsosplatVolume* record);
void isosplat_renderer_remove_volume(uint32_t volume);

/// Reserves room for the samples of a chunk: Renderer::reserve_chunk. `clusters`: those of
/// isosplat_core_decode_chunk. `handle`: chosen by the caller. Binds the vertex buffer to
/// ARRAY_BUFFER and sets *offset, in bytes. JavaScript uploads the samples there with
/// bufferSubData, without a copy in this heap.
IsosplatStatus isosplat_renderer_reserve_chunk(uint32_t volume, uint32_t handle,
                                               const IsosplatBlock* block, const void* clusters,
                                               uint32_t cluster_bytes, double* offset);

/// Renderer::bind_samples: binds the vertex buffer of a chunk to ARRAY_BUFFER, from which
/// getBufferSubData reads its samples (PackedSample).
IsosplatStatus isosplat_renderer_bind_samples(uint32_t volume, uint32_t handle,
                                              IsosplatSampleRange* range);

/// Renderer::set_field: sets the field of a volume, or removes it if the record is null. Frees the
/// values of its chunks in any case.
IsosplatStatus isosplat_renderer_set_field(uint32_t volume, const IsosplatFieldMapping* record);

/// Renderer::reserve_chunk_field: reserves room for the values of the field at the samples of a
/// chunk, 16 bytes each (PackedField), in the order of the samples that were uploaded. Binds their
/// buffer to ARRAY_BUFFER and sets *offset, in bytes, for bufferSubData.
IsosplatStatus isosplat_renderer_reserve_chunk_field(uint32_t volume, uint32_t handle,
                                                     uint32_t samples, double* offset);

/// Renderer::check_gpu: returns the errors of the GPU since the last call.
IsosplatStatus isosplat_renderer_check_gpu();
void isosplat_renderer_remove_chunk(uint32_t volume, uint32_t handle);

/// Draws exactly these chunks of the volume from now on.
void isosplat_renderer_set_visible(uint32_t volume, const IsosplatDrawnChunk* chunks,
                                   uint32_t count);

/// Sets the isosurfaces of one volume; those of other volumes stay. At most kMaxIsosurfaces; more
/// are ignored. The volume need not have been set yet.
void isosplat_renderer_set_isosurfaces(uint32_t volume, const IsosplatIsosurface* isosurfaces,
                                       uint32_t count);

/// kind: SplatKind; shading: Shading.
void isosplat_renderer_set_splats(uint32_t kind, uint32_t shading);
void isosplat_renderer_set_appearance(const IsosplatAppearance* appearance);
/// RenderSettings::field_categories: `count` × 3 bytes, sRGB, of the values `first`, + 1, …
void isosplat_renderer_set_categories(double first, const uint8_t* colours, uint32_t count);
void isosplat_renderer_set_light(const IsosplatLight* light);

/// The colours of a ColourMap, from low to high: `colourMapColours` × 3 bytes, sRGB. Null if there
/// is no such map. The table is static.
const uint8_t* isosplat_renderer_colour_map(uint32_t colour_map);

/// At most kMaxClipPlanes planes; more are ignored.
void isosplat_renderer_set_clipping(const IsosplatClipBox* box, const IsosplatPlane* planes,
                                    uint32_t count);

/// RenderSettings::slices of a volume, as the planes in which they lie, and the values that they
/// show as black and as white; `mapped`, 0 or 1: in the colours of the map instead. At most
/// kMaxSlices; more are ignored.
void isosplat_renderer_set_slices(uint32_t volume, const IsosplatPlane* planes, uint32_t count,
                                  double low, double high, uint32_t mapped);

void isosplat_renderer_set_camera(const IsosplatCamera* camera);

/// The camera of the first picture, which shows all volumes. `aspect`: width / height of the image.
/// Reads `orthographic` of the record, and keeps it.
void isosplat_renderer_default_camera(IsosplatCamera* camera, double aspect);

/// These change the camera: orbited(), panned(), zoomed() and bounded() in
/// shared/render/settings/camera.h.
void isosplat_renderer_orbit(IsosplatCamera* camera, double right_degrees, double up_degrees);
void isosplat_renderer_pan(IsosplatCamera* camera, double right_px, double down_px,
                           double image_height_px);
void isosplat_renderer_zoom(IsosplatCamera* camera, double factor);
void isosplat_renderer_bound(IsosplatCamera* camera);

/// The projection that draw() uses for a picture of this size. The selection needs it.
void isosplat_renderer_projection(const IsosplatCamera* camera, int32_t width, int32_t height,
                                  IsosplatProjection* projection);

/// The surface at a position in an image of this size, relative to its upper left corner:
/// Renderer::pick. The camera is that of isosplat_renderer_set_camera.
IsosplatStatus isosplat_renderer_pick(double x, double y, int32_t width, int32_t height,
                                      IsosplatPick* pick);

/// Whether draw() with this size would change the picture.
bool isosplat_renderer_needs_redraw(int32_t width, int32_t height);

/// Draws to the canvas, which has this size in pixels. `statistics` may be null.
IsosplatStatus isosplat_renderer_draw(int32_t width, int32_t height,
                                      IsosplatFrameStatistics* statistics);

/// Whether refine() would smooth the edges of the picture that was drawn last, with this size.
bool isosplat_renderer_can_refine(int32_t width, int32_t height);

/// Starts to compile the programs that refine() needs. Returns whether refine() would not wait for
/// them.
bool isosplat_renderer_prepare_refine();

/// Draws the picture again, shifted by a fraction of a pixel, and shows the mean of all such
/// pictures. `statistics` may be null.
IsosplatStatus isosplat_renderer_refine(int32_t width, int32_t height,
                                        IsosplatFrameStatistics* statistics);

/// Shows the finished picture of draw() and refine(), and performs only the passes that are still
/// missing (Renderer::draw_still). `statistics` may be null.
IsosplatStatus isosplat_renderer_draw_still(int32_t width, int32_t height,
                                            IsosplatFrameStatistics* statistics);

/// A picture of any size in tiles: Renderer::begin_tiles, draw_tile and end_tiles. `rgba`: 4 ×
/// width × height bytes.
IsosplatStatus isosplat_renderer_begin_tiles(int32_t width, int32_t height);
IsosplatStatus isosplat_renderer_draw_tile(int32_t x, int32_t y, int32_t width, int32_t height,
                                           int32_t pictures, uint8_t* rgba);
void isosplat_renderer_end_tiles();

/// Renderer::hold_picture, begin_fade and fade. `has_begun` is 0 if there is no picture to fade
/// from.
IsosplatStatus isosplat_renderer_hold_picture();
IsosplatStatus isosplat_renderer_begin_fade(uint32_t* has_begun);
IsosplatStatus isosplat_renderer_fade(float progress);

/// Starts an occlusion query for the picture that was drawn last: which regions of these chunks of
/// a volume show in at least min_px pixels (Renderer::begin_occlusion_query).
IsosplatStatus isosplat_renderer_begin_occlusion_query(uint32_t volume, const uint32_t* handles,
                                                       uint32_t count, int32_t min_px);

/// Takes the answer of the query, if it is ready. isosplat_renderer_occlusion_answer() then returns
/// answer->count records, which are valid until the next call of this function.
IsosplatStatus isosplat_renderer_take_occlusion_query(IsosplatOcclusionAnswer* answer);
const IsosplatVisibility* isosplat_renderer_occlusion_answer();

/// The name of the GL implementation (GL_RENDERER; empty without a renderer), valid until the next
/// call.
const char* isosplat_renderer_name();

/// Call these on the canvas's events webglcontextlost (after preventDefault) and
/// webglcontextrestored. All chunks are lost: add them again after the latter.
void isosplat_renderer_context_lost();
IsosplatStatus isosplat_renderer_context_restored();
}
