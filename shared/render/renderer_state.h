#pragma once

#include <GLES3/gl3.h>

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>
#include <vector>

#include "shared/render/accumulation.h"
#include "shared/render/cross_fade.h"
#include "shared/render/depth_tiles.h"
#include "shared/render/drawn_depths.h"
#include "shared/render/frame.h"
#include "shared/render/gl_program.h"
#include "shared/render/occluders.h"
#include "shared/render/occlusion_query.h"
#include "shared/render/renderer.h"
#include "shared/render/sample_buffers.h"
#include "shared/render/sample_clusters.h"
#include "shared/render/surface_targets.h"
#include "shared/render/vertex_runs.h"

namespace isosplat {

/// Binding point of the uniform block Frame.
inline constexpr GLuint kFrameBinding = 0;

/// What the GL implementation offers, and by how much images are enlarged for points whose centres
/// lie outside.
struct GlLimits {
  RendererLimits offered;
  float guard_px = 0;
  bool parallel_compile = false;  // KHR_parallel_shader_compile
  bool multi_draw = false;        // WEBGL_multi_draw
  bool on_cpu = false;            // llvmpipe: what is drawn waits for a flush, then has threads
};

/// The renderer's insides. Its functions are defined by duty: renderer_objects.cpp makes and
/// deletes what belongs to the context, splat_passes.cpp draws into the layers, picture.cpp makes
/// the picture of them; renderer.cpp keeps chunks and settings.
struct Renderer::State {
  /// Passes of drawing splats; each is a program.
  enum Pass { pass_quad, pass_ellipse, pass_exact, pass_visibility, pass_accumulate, kPasses };

  /// Programs that go over a whole image, or draw a mesh.
  enum ImagePass {
    pass_compose,  ///< and the three after it: + 1 for several layers, + 2 for eye-dome lighting
    pass_normalise = pass_compose + 4,
    pass_present,
    pass_darken,
    pass_fade,
    pass_read,
    pass_mesh,
    pass_lit_mesh,
    kImagePasses
  };

  /// Programs are started, and finished, when they are first needed; some are started earlier.
  struct ImageProgram {
    GlProgram program;
    bool is_ready = false;
  };
  struct SplatProgram {
    GlProgram program;
    bool is_ready = false;
    GLint block = -1, quantized_isovalue = -1, isosurface = -1, scalar = -1, drops_hidden = -1;
  };

  struct Chunk {
    SampleRange range;
    BlockKey block;
    CellInterval interval;  // of all samples: min of mins, max of maxes
    Vec3d low, high;        // box in cells of level 0
    std::vector<SampleCluster> clusters;
  };

  /// An estimate, before drawing, of whether a cluster of a drawn chunk is visible.
  enum class ExpectedVisibility : uint8_t { none, likely, unlikely };

  /// Which clusters a pass draws, and whether its vertex shaders drop what is hidden behind what is
  /// drawn already.
  enum class Share : uint8_t { all, likely_seen, not_hidden_of_rest, not_hidden };

  /// A visible chunk in this frame.
  struct DrawItem {
    ChunkHandle handle;
    const Chunk* chunk;
    double nearest;
    std::array<float, 4> block;
    RegionMask regions;
    float largest_px;           // no splat of it is larger
    uint32_t first_visibility;  // its clusters' in `visibilities`
  };

  float max_point_size = 1;
  GlLimits limits;
  bool lost = false;
  bool dirty = true;
  int drawn_width = 0, drawn_height = 0;
  bool lit = false;      // the last draw made a picture, and no layers but depths
  bool sheared = false;  // the grid is: splat programs know

  std::optional<VolumeGrid> grid;
  ValueMapping mapping;
  RenderSettings settings;
  Camera camera;

  std::unordered_map<ChunkHandle, Chunk> chunks;
  std::vector<DrawnChunk> visible;
  SampleBuffers buffers;

  SurfaceTargets targets;
  Occluders occluders;
  DrawnDepths drawn_depths;
  DepthTiles depth_tiles;
  int layers = 1;                 // of `targets`, that the last draw used
  int layer_of[kMaxIsosurfaces];  // by isosurface; −1: not drawn
  Accumulation accumulation;
  CrossFade cross_fade;
  OcclusionQuery occlusion_query;
  SplatProgram splat_programs[kPasses][2][2][2];  // [pass][pulled][clipped][lit]
  ImageProgram image_programs[kImagePasses];
  GLuint frame_buffer = 0, empty_vertex_array = 0, colour_map = 0;
  int colour_map_loaded = -1;
  GLuint sample_texture = 0;
  int sample_texture_rows = 0;

  GLuint mesh_vertex_array = 0, mesh_buffers[2] = {0, 0};
  GLsizei mesh_indices = 0;
  uint64_t mesh_bytes = 0;

  // Kept between frames: no allocation once warm.
  std::vector<DrawItem> items;
  VertexRuns runs;  // of the item being drawn
  std::vector<ExpectedVisibility>
      visibilities;  // of the clusters of all items, for the isosurface being drawn
  std::vector<PackedSample> ordered;
  FrameStatistics statistics;

  Result<void> make_gl_objects();
  void abandon_gl_objects();
  void release_gl_objects();
  void start(SplatProgram& splat, Pass pass, bool pulled, bool clipped);
  void start_first_splat_programs();
  void set_sheared(bool is_sheared);
  Result<SplatProgram*> splat_program(Pass pass, bool pulled, bool clipped);
  void start(ImageProgram& image, int pass);
  Result<const GlProgram*> image_program(int pass);
  int compose_pass() const {
    return pass_compose + (layers > 1 ? 1 : 0) + (settings.eye_dome > 0 ? 2 : 0);
  }
  Result<void> warm_up(GLuint framebuffer);
  template <typename Visit>
  void for_each_splat_program(Visit visit) {
    for (auto& pass : splat_programs) {
      for (auto& pulled : pass) {
        for (auto& clipped : pulled) {
          for (SplatProgram& program : clipped) visit(program);
        }
      }
    }
  }
  bool is_visible(ChunkHandle handle) const {
    return std::any_of(visible.begin(), visible.end(),
                       [handle](const DrawnChunk& chunk) { return chunk.handle == handle; });
  }
  void collect_items(const Frame& frame);
  uint64_t estimate_visibility(const Frame& frame, float quantized_isovalue);
  static Occluders::Box cluster_box(const Frame& frame, const DrawItem& item,
                                    const SampleCluster& cluster);
  template <typename Draw>
  void for_each_run(const DrawItem& item, Share share, Draw draw) const;
  Result<void> draw_splats(Pass pass, const Frame& frame, int isosurface, Share share);
  Result<void> draw_culled(Pass pass, const Frame& frame, int isosurface,
                           const SplatTarget& target);
  void take_depths(Pass pass, const SplatTarget& target);
  Result<void> draw_isosurface(SplatKind kind, const Frame& frame, int isosurface, int layer);
  void load_samples(const SampleRange& range);
  void load_colour_map();
  void set_light(const GlProgram& program);
  std::array<float, 3> scalar_weights(const Frame& frame, const Isosurface& surface,
                                      uint32_t level) const;
  Result<void> draw_mesh(const Frame& frame);
  bool can_be_lit_at_once() const;
  Result<void> draw_layers(int width, int height, ImageOffset offset, bool at_once);
  Result<void> show_lit(GLuint framebuffer);
  Result<void> compose(GLuint framebuffer, bool as_linear);
  Result<FrameStatistics> finish_frame();
  Result<FrameStatistics> draw(int width, int height, GLuint framebuffer);
  Result<FrameStatistics> refine(GLuint framebuffer);
  Result<void> fade(float progress, GLuint framebuffer);
};

}  // namespace isosplat
