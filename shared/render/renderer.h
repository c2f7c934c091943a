#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/drawn_chunk.h"
#include "shared/core/grid/grid.h"
#include "shared/core/sampling/packed_field.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/core/sampling/sample_clusters.h"
#include "shared/render/gl/gl_limits.h"
#include "shared/render/passes/frame_statistics.h"
#include "shared/render/passes/mesh_vertex.h"
#include "shared/render/passes/surface_pixel.h"
#include "shared/render/pick/surface_pick.h"
#include "shared/render/samples/sample_buffers.h"
#include "shared/render/settings/camera.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// The number of pictures whose mean a still picture is (Renderer::draw_still).
inline constexpr int kStillPictures = 8;

/// Draws chunks of packed samples of one or several volumes with OpenGL ES 3.0 or WebGL 2, from the
/// same source. Volumes are in one world, and have one depth order and one light. The first volume
/// is the one with the smallest number.
///
/// A GL context must be current on the calling thread in every call, and it must be the one that
/// was current at creation. The renderer leaves GL state changed (framebuffer, viewport, program,
/// textures, blending): it expects to own the context. It keeps no samples in CPU memory.
///
/// Context loss: all GL objects are lost, and with them all chunks. Call context_lost() at once.
/// Until the context is restored, calls draw nothing, and those that can fail return gl_error. When
/// a new context is current, call context_restored() and add the chunks again. Volume, settings and
/// camera are kept.
class Renderer {
 public:
  /// Starts to compile the shaders that most pictures need, and does not wait for them.
  /// `max_point_size`: upper limit of the size of points, in px, for tests of larger splats.
  static Result<std::unique_ptr<Renderer>> create(float max_point_size = 1024);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const RendererLimits& limits() const;

  /// Whether the driver has finished compiling all programs that were started. If so, warm_up()
  /// does not wait. Also true if the driver cannot report this.
  bool is_compiled() const;

  /// Makes the driver complete work that it defers to the first draw call. Call it while the first
  /// samples are being fetched. Draws one pixel of background into `framebuffer`, as draw() does.
  /// Errors: gl_error.
  Result<void> warm_up(uint32_t framebuffer = 0);

  /// Adds a volume, or replaces the one with this number and removes its chunks. Settings and
  /// camera are kept. To transform a volume affinely, pass its transformed grid.
  void set_volume(const VolumeGrid& grid, const ValueMapping& mapping, VolumeId volume = 0);
  /// Moves a volume and its chunks: sets a grid of the same voxels with another origin, direction
  /// or spacing. Errors: invalid_argument (no such volume, or another number of voxels).
  Result<void> move_volume(const VolumeGrid& grid, VolumeId volume = 0);
  /// Removes a volume and its chunks. Unknown numbers are ignored.
  void remove_volume(VolumeId volume);

  /// Uploads samples; the caller may free them afterwards. A chunk of the volume with the same
  /// handle is replaced. New chunks are not visible until set_visible names them. Empty spans are
  /// allowed. Errors: invalid_argument (no volume, or a block outside of it), gl_error (the context
  /// is lost). check_gpu() reports whether the GPU had memory for them.
  Result<void> add_chunk(ChunkHandle handle, const BlockKey& block,
                         std::span<const PackedSample> samples, VolumeId volume = 0);

  /// Like add_chunk of samples that cluster_samples has sorted, but leaves the upload to the
  /// caller: the vertex buffer is bound to GL_ARRAY_BUFFER. Returns the offset in bytes where the
  /// samples belong; upload them before the next call. Another error: invalid_argument (clusters
  /// that cluster_samples does not return).
  Result<uint64_t> reserve_chunk(ChunkHandle handle, const BlockKey& block,
                                 std::vector<SampleCluster> clusters, VolumeId volume = 0);

  /// Binds the vertex buffer of a resident chunk to GL_ARRAY_BUFFER, so that the caller can read
  /// its samples back, in the order in which they were uploaded. Binds nothing if there are none.
  /// Errors: invalid_argument (no such chunk), gl_error (the context is lost).
  Result<SampleRange> bind_samples(ChunkHandle handle, VolumeId volume = 0) const;

  /// Sets or removes the field of a volume: a second scalar with this mapping, whose values colour
  /// its surfaces with ColourBy::field. The values that its chunks have are freed in any case.
  /// set_volume() removes the field as well. Errors: invalid_argument (no such volume).
  Result<void> set_field(const std::optional<ValueMapping>& field, VolumeId volume = 0);

  /// Uploads the values of the volume's field at the cells of a chunk: one for each sample, in the
  /// order of cluster_samples. Replaces earlier ones. They are freed with the chunk, and lost when
  /// the chunk is added again. Until then surfaces have the colours of their isosurfaces. Errors:
  /// invalid_argument (no field, no such chunk, or another number of samples), gl_error (the
  /// context is lost). check_gpu() reports whether the GPU had memory for them.
  Result<void> set_chunk_field(ChunkHandle handle, std::span<const PackedField> values,
                               VolumeId volume = 0);

  /// The same, but leaves the upload of 16 · `samples` bytes to the caller, as reserve_chunk does.
  /// Binds the buffer to GL_ARRAY_BUFFER, and returns the offset in bytes where the values belong.
  /// The buffer stays unbound if there are no samples.
  Result<uint64_t> reserve_chunk_field(ChunkHandle handle, uint64_t samples, VolumeId volume = 0);

  /// Reports GPU errors since the last call. Waits for pending GPU commands, so call it when the
  /// GPU is idle. Errors: out_of_memory, gl_error. After out_of_memory, the chunks without memory
  /// are removed, and the field values of other chunks if these have no memory; all of them were
  /// added since the last call.
  Result<void> check_gpu();

  /// Removes a chunk. Unknown handles are ignored.
  void remove_chunk(ChunkHandle handle, VolumeId volume = 0);

  /// Sets the chunks of a volume that draw() draws. Unknown handles are ignored. The caller ensures
  /// that no two chunks cover the same part of the volume.
  void set_visible(std::span<const DrawnChunk> chunks, VolumeId volume = 0);
  /// Draws all regions of each chunk.
  void set_visible(std::span<const ChunkHandle> handles, VolumeId volume = 0);

  /// The grid of a volume; a grid of 2³ voxels if there is no volume with this number.
  const VolumeGrid& grid(VolumeId volume = 0) const;
  /// A grid around all volumes, for the camera: that of the only volume, or a box along the world's
  /// axes; a grid of 2³ voxels if there is no volume.
  VolumeGrid scene_grid() const;

  void set_settings(const RenderSettings& settings);
  const RenderSettings& settings() const;
  void set_camera(const Camera& camera);
  const Camera& camera() const;

  /// Sets a triangle mesh that is drawn instead of samples, in the first isosurface's colour. An
  /// empty mesh restores samples. For the comparison benchmarks. Errors: out_of_memory, gl_error.
  Result<void> set_mesh(std::span<const MeshVertex> vertices, std::span<const uint32_t> triangles);

  /// Whether the next draw of this size would differ from the last one.
  bool needs_redraw(int width, int height) const;

  /// Draws into `framebuffer` (0: the canvas), whose colour attachment is RGBA8 and has that size.
  /// Errors: gl_error (also: after a context loss), invalid_argument (size outside 1 … 16384).
  Result<FrameStatistics> draw(int width, int height, uint32_t framebuffer = 0);

  /// Whether refine() can improve the last picture: nothing has changed since draw(), fewer than
  /// eight pictures are accumulated, and the GPU has float targets.
  bool can_refine(int width, int height) const;

  /// Starts to compile the shaders of refine(). Returns false while the driver compiles them; then
  /// call it again later. Returns true when refine() would not wait for the driver. Waits itself if
  /// the driver cannot report its progress.
  bool prepare_refine();

  /// Improves a still picture: draws it again, moved by a fraction of a pixel, and shows the mean
  /// of all pictures since draw(). The mean has smooth edges, and the ambient occlusion and shadows
  /// of RenderSettings::light, which draw() omits. Each call costs a draw. Errors: as draw();
  /// invalid_argument if can_refine() returns false.
  Result<FrameStatistics> refine(int width, int height, uint32_t framebuffer = 0);

  /// Shows the finished picture of draw() and refine(), and performs only the passes that are still
  /// missing: after the last refine() it costs one pass over the pixels. A browser may clear its
  /// canvas between two tasks, so a picture must be shown again to be saved. Errors: as draw().
  Result<FrameStatistics> draw_still(int width, int height, uint32_t framebuffer = 0);

  /// Begins a picture of this size in tiles. The memory needed depends on the size of the tiles,
  /// not on that of the picture. Neither volume, settings, camera nor visible chunks may change
  /// until end_tiles(). Errors: as draw().
  Result<void> begin_tiles(int width, int height);

  /// Draws a part of the picture, from x px to the right of and y px below its upper left corner,
  /// and reads it: RGBA, alpha not premultiplied, rows from the top, 4 × width × height bytes.
  /// `pictures`: how many are averaged: 1 as draw() would draw the whole, kStillPictures as
  /// draw_still() would. It differs from the whole picture only by rounding, except in ambient
  /// occlusion and shadows: occluders that are kTileMargin px or more outside of the part are less
  /// exact. Errors: as draw(); also invalid_argument without begin_tiles(), for a part outside of
  /// the picture, or another number of bytes.
  Result<FrameStatistics> draw_tile(int x, int y, int width, int height, int pictures,
                                    std::span<uint8_t> rgba);

  /// Frees the memory of the tiles. The next draw() draws the picture again.
  void end_tiles();

  /// Copies the picture in the framebuffer, so that a later draw() can fade from it. Call it in the
  /// same task as the draw() or refine() that made the picture. Errors: gl_error, invalid_argument
  /// (nothing drawn yet).
  Result<void> hold_picture(uint32_t framebuffer = 0);

  /// Call it right after draw(). Begins to fade from the held picture to the new one, and shows the
  /// held one. Returns false, and does nothing, if no picture of this size is held. Errors:
  /// gl_error.
  Result<bool> begin_fade(uint32_t framebuffer = 0);

  /// Shows a mixture of both pictures: at 0 the held one, at 1 the new one, which is held from then
  /// on. Requires that begin_fade() returned true, and no draw since. Errors: gl_error.
  Result<void> fade(float progress, uint32_t framebuffer = 0);

  /// Reads all pixels of the opaque layer, row by row. Slow, since it waits for the GPU.
  /// Errors: gl_error, invalid_argument (nothing drawn yet).
  Result<std::vector<SurfacePixel>> read_surface();

  /// The nearest surface at a position in an image of this size, x px to the right of and y px
  /// below its upper left corner, with the current camera and settings; or the cap or the values of
  /// a slice before it. Intersects the ray with the cells of the visible chunks near it, in the
  /// precision of PackedSample, and does not depend on earlier draws. Finds the field's value on
  /// the surface as well, whatever the colours show. Returns nothing if there is no surface. Reads
  /// samples back from the GPU. Errors: gl_error, invalid_argument (no volume).
  Result<std::optional<SurfacePick>> pick(double x, double y, int width, int height) const;

  /// Starts an occlusion query, which finds the regions of these chunks of a volume that are
  /// visible in at least `min_px` pixels (1 … 255) of the last picture. The picture may show
  /// several volumes. Does not wait for the GPU. With `min_px` 0, a region is visible if any part
  /// of an active cell's box is in front of the surface at some pixel's centre: anything in the
  /// cell might be visible there. Chunks outside of set_visible() are skipped. Cancels a query in
  /// progress. Errors: gl_error, invalid_argument (no picture, or an outdated one: draw first).
  Result<void> begin_occlusion_query(std::span<const ChunkHandle> handles, int min_px,
                                     VolumeId volume = 0);

  /// Returns the result once. Returns nothing while the query is in progress, or if there is none.
  std::optional<std::vector<ChunkVisibility>> take_occlusion_query();

  /// See the class comment.
  void context_lost();
  Result<void> context_restored();

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::render
