#pragma once

#include <GLES3/gl3.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/render/gl/gl_program.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// Binding point of the uniform block Frame.
inline constexpr GLuint kFrameBinding = 0;

/// The lines that precede the files of programs with frame.glsl if the camera is orthographic.
inline constexpr std::string_view kOrthographicDefine = "#define ORTHOGRAPHIC\n";

/// Passes that draw samples: three kinds of splats, triangles, the gradients of smooth normals in
/// the image and at lattice points, the cells at cut faces, and those in slices.
enum class SplatPass : uint8_t {
  quad,
  ellipse,
  exact,
  triangles,  ///< always pulled
  gradients,
  lattice,  ///< always pulled
  cut_cells,
  slice_cells,
};
inline constexpr size_t kSplatPasses = 8;

/// A program of a splat pass.
struct SplatVariant {
  SplatPass pass = SplatPass::exact;
  bool pulled = false;   ///< fetches samples from a texture, and draws triangles instead of points
  bool clipped = false;  ///< there are clip planes
  bool lit = false;      ///< writes lit colours instead of surface pixels
  bool smooth = false;   ///< triangles: normals from gradients at lattice points
  FieldStyle field = FieldStyle::none;  ///< of the volume's field
};

/// A program that lights the surface pixels of layers, and blends the layers.
struct ComposeVariant {
  bool several_layers = false;
  bool eye_dome = false;
  bool still = false;          ///< ambient occlusion and shadows; writes linear colours
  bool tile = false;           ///< still: reads depths of the whole image where the tile has none
  bool many_surfaces = false;  ///< more than kMaxIsosurfaces: their colours are in a texture
  FieldStyle field = FieldStyle::none;
};

/// Other passes over the whole image, and those of the mesh.
enum class ImagePass : uint8_t {
  positions,        ///< positions of surface pixels, for smooth normals
  smooth_normals,   ///< sums of gradients become normals of surface pixels
  lattice_normals,  ///< normals of surface pixels, from gradients at lattice points
  replace_normals,  ///< these become those of surface pixels
  present,          ///< the mean of accumulated pictures
  darken,           ///< eye-dome lighting of a lit picture
  fade,
  cap_states,
  cap_tiles,
  cap_jump,
  caps,   ///< the layers with caps
  slice,  ///< the pattern of a slice
  read,   ///< surface pixels and depths, for reading back
  mesh,
  lit_mesh,
};
inline constexpr size_t kImagePasses = 15;

/// All shader programs of the renderer. A program is compiled when it is first needed; those of
/// most first pictures are started earlier, as drivers compile in the background.
class ShaderPrograms {
 public:
  /// A program with its uniform locations.
  struct Splat {
    GlProgram program;
    bool is_ready = false;  ///< linked, and its constant uniforms are set
    GLint block = -1, quantized_isovalue = -1, isosurface = -1, scalar = -1, drops_hidden = -1;
    GLint field = -1, field_missing = -1;  // of those that show a field
    GLint lines = -1, line_tones = -1;     // of those that show its contour lines
    GLint gradient_weight = -1, finest_side_px = -1, smooth_px = -1, per_cell = -1;  // of gradients
  };

  /// Starts to compile the programs of most first pictures, and does not wait.
  void start_first();

  /// Start to compile a program, and do not wait.
  void prepare(SplatVariant variant);
  void prepare(ImagePass pass);
  void prepare(ComposeVariant variant);

  /// True if every program that was started for the present camera is compiled. Requires
  /// KHR_parallel_shader_compile.
  bool is_compiled() const;

  /// Makes all programs ready that were started for the present camera, as splat(), image() and
  /// compose() do one by one: after draw calls, browsers would wait for these as well. Errors are
  /// those of the later calls.
  void finish_started();

  /// Splat programs are compiled for sheared grids or for grids with perpendicular axes. A change
  /// replaces them, and starts the first ones again.
  void set_sheared(bool sheared);

  /// Programs are compiled for orthographic or for perspective cameras. A change keeps those of the
  /// other camera, unless none of them has been used, and starts the first ones if there are none.
  void set_orthographic(bool orthographic);

  /// Return a linked program, and wait for the driver if necessary. Errors: gl_error, with the
  /// driver's log. Pointers stay valid until set_sheared(), set_orthographic() or abandon().
  Result<const Splat*> splat(SplatVariant variant);
  Result<const GlProgram*> image(ImagePass pass);
  Result<const GlProgram*> compose(ComposeVariant variant);

  /// Number of programs linked since the last reset.
  uint32_t linked_count() const { return linked_count_; }
  void reset_linked_count() { linked_count_ = 0; }

  /// The context that owned the programs is gone.
  void abandon();

 private:
  struct Image {
    GlProgram program;
    bool is_ready = false;
  };

  /// The programs for one kind of camera.
  struct Set {
    std::array<Splat, kSplatPasses * 64> splats;
    std::array<Image, kImagePasses> images;
    std::array<Image, 128> composes;
    bool is_started = false;

    bool is_used() const;
    void abandon();
  };

  Set& current() { return sets_[orthographic_ ? 1 : 0]; }
  const Set& current() const { return sets_[orthographic_ ? 1 : 0]; }
  Splat& slot(SplatVariant variant);
  Image& slot(ImagePass pass) { return current().images[static_cast<size_t>(pass)]; }
  Image& slot(ComposeVariant variant) {
    return current()
        .composes[32 * static_cast<size_t>(variant.field) + (variant.many_surfaces ? 16u : 0u) +
                  (variant.tile ? 8u : 0u) + (variant.still ? 4u : 0u) +
                  (variant.several_layers ? 2u : 0u) + (variant.eye_dome ? 1u : 0u)];
  }
  /// Takes the programs out of an entry that is replaced.
  template <class Entries>
  void retire(Entries& entries);
  void start_splats();
  GlProgram start(SplatVariant variant) const;
  GlProgram start(ImagePass pass) const;
  GlProgram start(ComposeVariant variant) const;
  GlProgram start_image(std::string_view defines,
                        std::initializer_list<std::string_view> fragment_files) const;
  Result<const GlProgram*> finish(Image& image);

  std::array<Set, 2> sets_;  // perspective, orthographic
  /// Programs that were replaced before they were known to be linked. While the driver links,
  /// Chromium asks for the state of a program, and reports an error if it was deleted.
  std::vector<GlProgram> retired_;
  bool sheared_ = false, orthographic_ = false;
  bool started_ = false;  // since the context exists
  uint32_t linked_count_ = 0;
};

/// Sets u_isosurfaces of the current program: the numbers of a volume's isosurfaces, at most
/// kMaxIsosurfaces, and −1 after them.
void set_isosurfaces(const GlProgram& program, std::span<const int> isosurfaces);

}  // namespace isosplat::render
