#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/drawn_chunk.h"
#include "shared/render/camera.h"
#include "shared/sampling/packed_sample.h"
#include "shared/sampling/projection.h"
#include "shared/sampling/sample_clusters.h"

namespace isosplat {

/// What a projected sample is drawn as.
enum class SplatKind : uint8_t {
  quad,     ///< squares of one depth (QSplat), cut where they are seen from the edge; the fastest
  ellipse,  ///< pieces of the tangent plane, moved to the cell's surface at each pixel
  blended,  ///< ellipses weighted and normalised (EWA), anti-aliased edges; needs float targets
  exact,    ///< the pixel's ray meets the cell's trilinear surface
};

/// What decides a pixel's colour.
enum class ColourBy : uint8_t {
  isosurface,        ///< Isosurface::colour
  isovalue,          ///< the isovalue's place in [colour_low, colour_high], values
  gradient,          ///< |∇f| in values per world unit, within [colour_low, colour_high]
  depth,             ///< distance from the eye along the view, near to far side of the volume
  level,             ///< level of detail: 0 is one end of the map, 7 the other
  projection_error,  ///< distance of the projected sample from the isosurface, 0 to ½ cell
};

enum class ColourMap : uint8_t { viridis, magma, cividis, turbo };
inline constexpr int kColourMaps = 4;

inline constexpr int kMaxIsosurfaces = 8;
inline constexpr int kMaxClipPlanes = 6;

struct Isosurface {
  double isovalue = 0;              ///< in the volume's values
  Vec3f colour{0.85f, 0.8f, 0.7f};  ///< sRGB (as gamma 2: README.md), 0 … 1
  float opacity = 1;                ///< 0 … 1
};

/// Keeps what lies on the normal's side: dot(normal, world) ≥ offset.
struct ClipPlane {
  Vec3d normal{0, 0, 1};
  double offset = 0;
};

/// Everything that decides how the surface looks. Plain data: compare, copy, keep in a URL.
struct RenderSettings {
  std::vector<Isosurface> isosurfaces;  ///< at most kMaxIsosurfaces; more are ignored
  SplatKind kind = SplatKind::ellipse;
  ColourBy colour_by = ColourBy::isosurface;
  ColourMap colour_map = ColourMap::viridis;
  double colour_low = 0, colour_high = 1;
  std::array<float, 4> background{1, 1, 1, 1};  ///< sRGB, not premultiplied
  float ambient = 0.25f;                        ///< light that reaches every side
  float specular = 0.15f;
  float eye_dome = 0.5f;  ///< strength of eye-dome lighting, 0: none
  float splat_scale = 1;  ///< multiplies the footprint; 1 closes all holes
  bool projected = true;  ///< false draws samples where they were generated (paper, figure 4)
  Displaced displaced = Displaced::clamp;
  std::vector<ClipPlane> clip_planes;  ///< at most kMaxClipPlanes; more are ignored
  Vec3d clip_box_low{0, 0, 0}, clip_box_high{1, 1, 1};  ///< fractions of the volume's extent

  friend bool operator==(const RenderSettings&, const RenderSettings&);
};

/// Where a chunk's samples lie.
struct ChunkPlace {
  BlockKey block;
};

/// What a draw did. Kept by the renderer until the next draw.
struct FrameStatistics {
  /// Of clusters (8³ cells) with a part of an isosurface in the image, once for each isosurface.
  uint64_t samples_drawn = 0;
  uint64_t samples_resident = 0;
  uint64_t gpu_bytes = 0;  ///< buffers and targets that the renderer holds
  uint32_t chunks_drawn = 0;
  uint32_t chunks_culled = 0;  ///< visible by set_visible, outside of the frustum or clip box
  uint32_t draw_calls = 0;
  uint32_t programs_linked = 0;      ///< for the first time in this draw, which took longer for it
  SplatKind kind = SplatKind::quad;  ///< that was drawn: blended may have fallen back to ellipse
};

/// What the GL implementation at hand offers, asked once.
struct RendererLimits {
  float max_point_size = 1;  ///< larger splats are drawn as two triangles
  int max_texture_size = 0;
  bool float_targets = false;  ///< EXT_color_buffer_float: the blended kind is available
  bool float_blend = false;    ///< EXT_float_blend: 32-bit accumulation, else 16
  std::string renderer;        ///< GL_RENDERER
};

/// Vertices of an indexed triangle mesh, drawn by the same renderer for comparison.
struct MeshVertex {
  Vec3f position;  ///< world, relative to the volume's centre (bounding_sphere(grid).centre)
  Vec3f normal;    ///< need not be of unit length
};

/// Draws chunks of packed samples with OpenGL ES 3.0 or WebGL 2. One source for both.
///
/// A GL context must be current on the calling thread in every call, and it must be the one that
/// was current at creation. The renderer leaves GL state changed (framebuffer, viewport, program,
/// textures, blending): it expects to own the context. It holds no samples on the CPU's side.
///
/// Context loss: all GL objects are gone, and with them all chunks. Call context_lost() as soon as
/// it is known; every call is then harmless and draws nothing. When a context is back and current,
/// call context_restored() and add the chunks again; volume, settings and camera are kept.
class Renderer {
 public:
  /// Starts to compile the shaders that most pictures need, and does not wait for them.
  /// `max_point_size`: draws no larger points even where the GL can (for tests of the other way).
  static Result<std::unique_ptr<Renderer>> create(float max_point_size = 1024);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const RendererLimits& limits() const;

  /// Whether the driver has compiled what was started, so that warm_up() need not wait for it.
  bool is_compiled() const;

  /// Has the driver finish what it puts off until something is drawn: call it while the first
  /// samples are on their way. Draws one pixel of background into `framebuffer`, as draw() does.
  /// Errors: gl_error.
  Result<void> warm_up(uint32_t framebuffer = 0);

  /// Another volume: forgets all chunks. Settings and camera stay.
  void set_volume(const VolumeGrid& grid, const ValueMapping& mapping);

  /// Uploads samples; the caller may free them afterwards. A chunk with the same handle is
  /// replaced. New chunks are not visible until set_visible names them. Empty spans are allowed.
  /// Errors: invalid_argument (no volume, or a block outside of it), gl_error (the context is
  /// lost), out_of_memory. Some drivers find out late: check_gpu() tells.
  Result<void> add_chunk(ChunkHandle handle, ChunkPlace place,
                         std::span<const PackedSample> samples);

  /// Like add_chunk of samples that cluster_samples has sorted, but leaves the upload to the
  /// caller: the vertex buffer is bound to GL_ARRAY_BUFFER. Returns the offset in bytes where the
  /// samples belong; upload them before the next call. Another error: invalid_argument (clusters
  /// that cluster_samples does not return).
  Result<uint64_t> reserve_chunk(ChunkHandle handle, ChunkPlace place,
                                 std::vector<SampleCluster> clusters);

  /// What went wrong on the GPU since the last call. Waits until it has done what it was told, so
  /// call it when it has. Errors: out_of_memory, gl_error.
  Result<void> check_gpu() const;

  /// Forgets a chunk; unknown handles are ignored.
  void remove_chunk(ChunkHandle handle);

  /// The chunks that draw() considers, from now on. Unknown handles are ignored. The caller sees to
  /// it that no part of the volume is covered by two levels at once.
  void set_visible(std::span<const DrawnChunk> chunks);
  void set_visible(std::span<const ChunkHandle> handles);  ///< wholly

  void set_settings(const RenderSettings& settings);
  const RenderSettings& settings() const;
  void set_camera(const Camera& camera);
  const Camera& camera() const;

  /// A triangle mesh that is drawn in place of samples, in the first isosurface's colour; an empty
  /// one goes back to samples. For the comparison benchmarks. Errors: out_of_memory, gl_error.
  Result<void> set_mesh(std::span<const MeshVertex> vertices, std::span<const uint32_t> triangles);

  /// Whether the next draw would differ from the last one of the same size. A still view needs
  /// none.
  bool needs_redraw(int width, int height) const;

  /// Draws into `framebuffer` (0: the canvas), whose colour attachment is RGBA8 and has that size.
  /// Errors: gl_error (also: after a context loss), invalid_argument (size outside 1 … 16384).
  Result<FrameStatistics> draw(int width, int height, uint32_t framebuffer = 0);

  /// Whether refine() would make the last picture better: nothing has changed since the draw, it is
  /// not yet as good as it gets, and the GPU has float targets.
  bool can_refine(int width, int height) const;

  /// Smooths the edges of a view that stands still: draws it once more, moved by a part of a pixel,
  /// and shows the mean of all pictures since draw(). Costs a draw each time. Errors: as draw();
  /// invalid_argument where can_refine() says no.
  Result<FrameStatistics> refine(int width, int height, uint32_t framebuffer = 0);

  /// Keeps the picture that the framebuffer shows: call it in the task of the draw() or refine()
  /// that made it. What the next draw() makes can then come in its place step by step. Errors:
  /// gl_error, invalid_argument (nothing drawn yet).
  Result<void> hold_picture(uint32_t framebuffer = 0);

  /// Right after a draw(): begins to fade from the held picture to this one, and shows the held
  /// one. Answers false, and does nothing, where none of this size is held. Errors: gl_error.
  Result<bool> begin_fade(uint32_t framebuffer = 0);

  /// Shows both pictures mixed: at 0 the held one, at 1 the other, which is held from then on.
  /// Requires that begin_fade answered true, and no draw since. Errors: gl_error.
  Result<void> fade(float progress, uint32_t framebuffer = 0);

  /// What the last draw found at its pixels, for tests and for picking. y runs up, as in OpenGL.
  struct SurfacePixel {
    bool hit = false;
    float depth = 0;  ///< distance from the eye's plane along the view, world units
    Vec3f normal;     ///< in the camera's frame (right, up, towards the eye), unit length
    uint32_t isosurface = 0;
    float coverage = 1;
  };
  /// Reads all pixels of the opaque layer, row by row. Slow: it waits for the GPU.
  /// Errors: gl_error, invalid_argument (nothing drawn yet).
  Result<std::vector<SurfacePixel>> read_surface();

  /// Starts to find out which regions of these chunks show in the picture drawn last, in at least
  /// so many pixels (1 … 255), and returns before the GPU has done it. With `min_px` 0 a region
  /// counts that does not lie wholly behind the picture: of which any part of an active cell's box
  /// is in front of what a pixel shows at its middle, so that whatever is in the cell might be seen
  /// there. Chunks that are not visible by set_visible are left out. Forgets a query that is under
  /// way. Errors: gl_error, invalid_argument (there is no picture, or it is no longer true: draw
  /// first).
  Result<void> begin_occlusion_query(std::span<const ChunkHandle> handles, int min_px);

  /// The answer, once; nothing while the GPU is at work, or where none was begun.
  std::optional<std::vector<ChunkVisibility>> take_occlusion_query();

  /// See the class comment.
  void context_lost();
  Result<void> context_restored();

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
