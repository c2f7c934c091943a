#pragma once

#include <GLES3/gl3.h>

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "shared/render/frame/image_tile.h"
#include "shared/render/gl/gl_errors.h"
#include "shared/render/gl/image_target.h"
#include "shared/render/passes/accumulation.h"
#include "shared/render/passes/clip_caps.h"
#include "shared/render/passes/cross_fade.h"
#include "shared/render/passes/draw_context.h"
#include "shared/render/passes/occlusion_query.h"
#include "shared/render/passes/slices.h"
#include "shared/render/passes/splat_passes.h"
#include "shared/render/passes/triangle_mesh.h"
#include "shared/render/renderer.h"
#include "shared/render/samples/chunk_store.h"

namespace isosplat::render {

/// Which layer of surface pixels each isosurface is drawn into.
struct LayerAssignment {
  int count = 1;                ///< layer 0 is for all opaque isosurfaces
  std::vector<int> by_surface;  ///< of the settings; −1: not drawn, as it is fully transparent
  std::vector<Isosurface> isosurfaces;  ///< of the settings, those of layer 0 with opacity 1
};

/// The grid while there is no volume.
inline constexpr VolumeGrid kNoVolume{{2, 2, 2}};

/// A volume of the picture and its resident chunks.
struct Volume {
  VolumeGrid grid;
  ValueMapping mapping;
  std::optional<ValueMapping> field;  ///< whose values its chunks may have
  ChunkStore chunks;
  DrawList list;            ///< of the last draw
  GLuint frame_buffer = 0;  ///< with the uniform block of its frame; 0: not drawn yet

  Volume(const VolumeGrid& grid_, const ValueMapping& mapping_, SampleBuffers& buffers)
      : grid(grid_), mapping(mapping_), chunks(buffers) {}
};

/// A volume with isosurfaces in the frame that was drawn last.
struct DrawnVolume {
  VolumeId id;
  Volume* volume;
  Frame frame;
  std::vector<int> isosurfaces;  ///< indices into those of the settings
  std::vector<int> layers;       ///< of each isosurface; −1: not drawn
};

/// A uniform buffer for the block of a frame.
GLuint new_frame_buffer();
void upload_frame(const FrameBlock& block, GLuint buffer);

/// The objects of a renderer, and the order of passes in a frame.
struct Renderer::State {
  float max_point_size = 1;
  GlLimits limits;
  bool lost = false;
  bool dirty = true;         // the next draw would differ from the last one
  ImageTile tile;            // of the frame that is being drawn
  ImageTile drawn_tile;      // of the last finished frame; at first of no size
  ImageOffset drawn_offset;  // of the surfaces that were drawn last
  bool lit = false;          // the last draw made a lit picture and depths, but no surface pixels

  SampleBuffers buffers;  // of all volumes: declared first, since their chunks are in it
  std::map<VolumeId, Volume> volumes;
  RenderSettings settings;
  Camera camera;

  GlErrors gl_errors;
  TriangleMesh mesh;
  ShaderPrograms programs;
  SurfaceTargets targets;
  SurfaceTargets whole_image;  // in few pixels, with the depths around a tile
  ImageTarget tile_picture{GL_RGBA8, "for a part"};
  ImageTile tiled_image;  // since begin_tiles(); at first of no size
  Lighting lighting;
  SplatPasses splat_passes;
  LayerAssignment layers;                   // of the last draw
  std::vector<DrawnVolume> drawn;           // of the last draw, nearest first
  SmoothSizes smooth_sizes = kDrawnSmooth;  // of the last draw
  ClipCaps caps;
  bool capped = false;  // the layers that were drawn last are in `caps` as well
  Slices slices;
  Accumulation accumulation;
  CrossFade cross_fade;
  OcclusionQuery occlusion_query;
  GLuint placeholder_frame = 0;  // its uniform block, while there is no volume
  GLuint empty_vertex_array = 0;
  FrameStatistics statistics;

  State() = default;
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Queries the limits of a new context, creates the first objects, and starts to compile.
  void create_gl_objects();
  /// The context that owned the objects is gone.
  void abandon_gl_objects();

  /// The first volume, or a placeholder: the passes over the image are in its frame space, and the
  /// clip box is a fraction of its extent.
  const VolumeGrid& first_grid() const {
    return volumes.empty() ? kNoVolume : volumes.begin()->second.grid;
  }
  SceneExtent scene_extent() const;
  Volume* find_volume(VolumeId id);
  const Volume* find_volume(VolumeId id) const;
  /// How colours show the field of any volume; none if no volume has a field.
  FieldStyle shown_style() const;
  /// Splat programs differ for sheared grids. If any volume has a sheared grid, all volumes use the
  /// programs for sheared grids.
  void choose_programs();

  Result<void> warm_up(GLuint framebuffer);
  Result<FrameStatistics> draw(const ImageTile& part, GLuint framebuffer);
  /// Starts to compile the programs that refine() needs after the picture that was drawn last.
  void start_still_programs();
  Result<FrameStatistics> refine(GLuint framebuffer);
  Result<void> begin_tiles(int width, int height);
  Result<FrameStatistics> draw_tile(const ImageTile& part, int pictures, std::span<uint8_t> rgba);
  void end_tiles();
  Result<FrameStatistics> show_mean(GLuint framebuffer);
  Result<void> fade(float progress, GLuint framebuffer);
  /// Draws the last picture's surface pixels, unless the last draw has done so.
  Result<void> ensure_layers();
  Result<void> begin_occlusion_query(const Volume& volume, std::span<const ChunkHandle> handles,
                                     int min_px);
  /// Starts to compile the programs that draw a lit picture of squares, and does not wait.
  void start_lit_programs();

  DrawContext context() { return context_of(targets); }
  /// The same with the layers that are shown: those with caps, if there are any.
  DrawContext shown_context() { return context_of(capped ? caps.targets() : targets); }

 private:
  DrawContext context_of(SurfaceTargets& layers_) {
    return {settings,   layers.isosurfaces, limits,        programs,          layers_, lighting,
            statistics, tile.image_height,  shown_style(), empty_vertex_array};
  }
  bool has_caps() const;
  Result<void> draw_caps();
  Result<void> draw_caps_and_slices();
  bool can_light_directly() const;
  void assign_layers();
  double scene_radius() const;
  Frame make_frame(const VolumeGrid& grid, const SceneExtent& scene, ImageOffset offset) const;
  void make_frames(ImageOffset offset);
  void bind_frame(GLuint frame_buffer) const;
  void bind_picture_frame() const;
  SplatFrame splats_of(DrawnVolume& drawn_volume) const;
  Result<void> draw_surfaces(const ImageTile& part, ImageOffset offset, bool light_directly,
                             SmoothSizes sizes = kDrawnSmooth);
  bool has_smooth_normals() const;
  Result<void> smooth_normals(std::span<DrawnVolume> of);
  Result<void> prepare_targets();
  Result<void> draw_splats(std::span<DrawnVolume> of);
  void clear_targets();
  Result<void> draw_mesh(const Frame& frame);
  Result<void> accumulate_picture();
  Result<FrameStatistics> finish_frame();
};

}  // namespace isosplat::render
