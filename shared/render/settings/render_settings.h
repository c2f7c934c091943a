#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/sampling/projection.h"
#include "shared/render/settings/light.h"
#include "shared/render/settings/plane.h"

namespace isosplat::render {

/// The shape as which a projected sample is drawn.
enum class SplatKind : uint8_t {
  quad,     ///< squares of one depth (QSplat), cut to a strip where seen edge-on; the fastest
  ellipse,  ///< pieces of the tangent plane, moved to the cell's surface at each pixel
  exact,    ///< intersection of the pixel's ray with the cell's trilinear surface
};

/// The normals of exact splats, ellipses, and quads that are drawn as triangles.
enum class Shading : uint8_t {
  /// Continuous across cells, chunks and levels: gradients of the cells around each lattice point
  /// are averaged, and interpolated. Needs float targets. Cells below 3 px have exact ones, and in
  /// still pictures (refine) those below half a pixel.
  smooth,
  exact,  ///< the gradient of the cell's trilinear function, which jumps from cell to cell
};

/// The quantity that a pixel's colour shows.
enum class ColourBy : uint8_t {
  isosurface,        ///< Isosurface::colour
  isovalue,          ///< the isovalue, in values, within [colour_low, colour_high]
  gradient,          ///< |∇f| in values per world unit, within [colour_low, colour_high]
  depth,             ///< distance from the eye along the view, from near plane to far plane
  level,             ///< level of detail, 0 to 7
  projection_error,  ///< distance of the projected sample from the isosurface, 0 to ½ cell
  /// The field of each volume (Renderer::set_field), in the field's values, within [colour_low,
  /// colour_high]. Surfaces without values have Isosurface::colour.
  field,
};

/// How the values of a field are laid out along the colour map.
enum class FieldScale : uint8_t {
  linear,       ///< from colour_low to colour_high
  logarithmic,  ///< the same for their logarithms; a limit that is not above 0: see field_range()
  symmetric,    ///< from −m to m, where m is the larger of |colour_low| and |colour_high|
};

enum class ColourMap : uint8_t { viridis, magma, cividis, turbo };
inline constexpr int kColourMaps = 4;

/// Identifies a volume of the picture: Renderer::set_volume.
using VolumeId = uint32_t;

inline constexpr int kMaxIsosurfaces = 8;  ///< of each volume
inline constexpr int kMaxTranslucent = 8;  ///< of all volumes; more are drawn as opaque
inline constexpr int kMaxClipPlanes = 6;
inline constexpr int kMaxSlices = 4;
inline constexpr size_t kMaxCategoryColours = 65534;

struct Isosurface {
  double isovalue = 0;              ///< in the volume's values
  Vec3f colour{0.85f, 0.8f, 0.7f};  ///< sRGB, 0 … 1
  float opacity = 1;                ///< 0 … 1
  VolumeId volume = 0;

  friend bool operator==(const Isosurface&, const Isosurface&) = default;
};

/// All settings of the picture except for the camera. Plain data that can be compared and copied.
struct RenderSettings {
  /// Of all volumes, at most kMaxIsosurfaces of each; more are ignored.
  std::vector<Isosurface> isosurfaces;
  SplatKind kind = SplatKind::ellipse;
  Shading shading = Shading::smooth;
  ColourBy colour_by = ColourBy::isosurface;
  ColourMap colour_map = ColourMap::viridis;
  double colour_low = 0, colour_high = 1;
  FieldScale field_scale = FieldScale::linear;
  int field_steps = 0;  ///< number of colours that show fields, ≥ 2; less: all of the map
  /// Distance of the contour lines of the field, in its values: lines are at the multiples of this.
  /// With a logarithmic scale it is in decades, and lines are at 10 to the multiples. Unless it is
  /// finite and above 0, there are no lines.
  double field_lines = 0;
  /// If not empty, the values of the field are categories: sRGB colours of the values
  /// field_first_category, + 1, + 2 …, at most kMaxCategoryColours; more are ignored. Each point
  /// shows the category of the nearest voxel, and the range, scale, steps and lines above have no
  /// effect. Values without a colour here are shown as missing ones.
  std::vector<std::array<uint8_t, 3>> field_categories;
  double field_first_category = 0;
  Vec3f field_missing_colour{0.62f, 0.62f, 0.62f};  ///< sRGB, where a field has no value
  std::array<float, 4> background{1, 1, 1, 1};      ///< sRGB, not premultiplied
  LightSettings light;
  float eye_dome = 0.15f;  ///< strength of edge shading (eye-dome lighting), 0: none … 1
  float splat_scale = 1;   ///< multiplies the footprint; 1 closes all holes
  bool projected = true;   ///< false: draws samples at their cells' centres (paper, figure 4)
  Displaced displaced = Displaced::clamp;
  /// Each keeps the half-space dot(normal, position) ≥ offset. At most kMaxClipPlanes; more are
  /// ignored.
  std::vector<Plane> clip_planes;
  /// Fractions of the extent of the first volume. The box clips all volumes.
  Vec3d clip_box_low{0, 0, 0}, clip_box_high{1, 1, 1};
  /// Closes the faces at which the clipping cuts the solid: the part of the volume whose values are
  /// at least the isovalue. The border of the volume stays open. It has no effect if `projected` is
  /// false.
  bool clip_caps = false;
  /// Planes in which the values of one volume are shown. At most kMaxSlices; more are ignored, as
  /// are planes without a unit_plane(). They show the values of all resident cells, visible or not;
  /// where levels overlap, those of the finest level. Elsewhere they show lines, between which the
  /// surfaces behind are visible. Where colours show isovalues, slices have the same colours. Else
  /// they are grey, from black at slice_low to white at slice_high, or, with slices_mapped, have
  /// the colours of colour_map between these values. They are not lit.
  std::vector<Plane> slices;
  double slice_low = 0, slice_high = 1;
  bool slices_mapped = false;
  VolumeId slice_volume = 0;

  friend bool operator==(const RenderSettings&, const RenderSettings&) = default;
};

/// The values of a field with the first and the last colour of the map. Logarithmic: both are above
/// 0; a high limit that is not is replaced by 1, and then such a low limit by a thousandth of the
/// high one.
struct FieldRange {
  double low = 0, high = 1;
};
FieldRange field_range(const RenderSettings& settings);

/// How colours show fields.
enum class FieldStyle : uint8_t {
  none,        ///< colours show other things
  values,      ///< by the colour map
  lines,       ///< the same with contour lines
  categories,  ///< each with its own colour
};
FieldStyle field_style(const RenderSettings& settings);

}  // namespace isosplat::render
