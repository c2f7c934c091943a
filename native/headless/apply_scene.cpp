#include <algorithm>

#include "native/headless/scene_picture.h"
#include "native/headless/show_categories.h"

namespace isosplat {
namespace {

using render::ColourBy;
using render::LightSettings;
using render::RenderSettings;

static_assert(int(SceneColouring::projection_error) == int(ColourBy::projection_error));
static_assert(int(SceneColouring::field) == int(ColourBy::field));
static_assert(int(SceneFieldScale::symmetric) == int(render::FieldScale::symmetric));
static_assert(int(SceneColourMap::turbo) == int(render::ColourMap::turbo));
static_assert(int(SceneShading::exact) == int(render::Shading::exact));

void set(float& setting, const std::optional<double>& value) {
  if (value) setting = static_cast<float>(*value);
}

void apply_light(const SceneLight& light, LightSettings& settings) {
  set(settings.azimuth, light.azimuth);
  set(settings.elevation, light.elevation);
  set(settings.key, light.key);
  set(settings.sky, light.sky);
  set(settings.rim, light.rim);
  set(settings.highlight, light.highlight);
  set(settings.roughness, light.roughness);
  set(settings.occlusion, light.occlusion);
  set(settings.occlusion_radius, light.occlusion_radius);
  set(settings.shadow, light.shadow);
  set(settings.shadow_softness, light.shadow_softness);
}

/// The ends of the colour map, as in the page (web/viewer/picture_settings.ts).
void set_colour_range(const FirstVolume& first, RenderSettings& settings) {
  settings.colour_low = first.low;
  settings.colour_high = first.high;
  if (settings.colour_by != ColourBy::gradient) return;
  // The largest gradient of the scale: half of the range of values within one cell, a sharp edge.
  const Vec3d& spacing = first.grid.spacing;
  settings.colour_low = 0;
  settings.colour_high =
      0.5 * (first.high - first.low) / std::min({spacing.x, spacing.y, spacing.z});
}

void apply_field(const SceneField& field, const std::optional<SceneFieldRange>& found,
                 RenderSettings& settings) {
  settings.field_scale = static_cast<render::FieldScale>(field.scale);
  settings.field_steps = field.steps;
  settings.field_lines = field.lines;
  const auto [low, high] = found.value_or(SceneFieldRange{0, 1});
  settings.colour_low = field.range ? field.range->low : low;
  settings.colour_high = field.range ? field.range->high : high;
}

void apply_look(const SceneLook& look, const ScenePicture& picture, RenderSettings& settings) {
  if (look.kind == SceneSplats::quad) settings.kind = render::SplatKind::quad;
  if (look.kind == SceneSplats::ellipse) settings.kind = render::SplatKind::ellipse;
  if (look.kind == SceneSplats::exact || look.kind == SceneSplats::automatic) {
    settings.kind = render::SplatKind::exact;
  }
  if (look.shading) settings.shading = static_cast<render::Shading>(*look.shading);
  if (look.colour_by) settings.colour_by = static_cast<ColourBy>(*look.colour_by);
  if (look.colour_map) settings.colour_map = static_cast<render::ColourMap>(*look.colour_map);
  if (picture.first) set_colour_range(*picture.first, settings);
  if (settings.colour_by == ColourBy::field && look.field) {
    apply_field(*look.field, picture.field_range, settings);
    show_categories(picture.categories, settings);
  }
  apply_light(look.light, settings.light);
  set(settings.eye_dome, look.eye_dome);
}

/// The plane across an axis of the grid, which need not be perpendicular to the others.
render::Plane plane_across(size_t axis, double share, const VolumeGrid& grid) {
  const Matrix3d edges = grid.cell_edges();
  const Vec3d normal = cross(column(edges, (axis + 1) % 3), column(edges, (axis + 2) % 3));
  const std::array<int32_t, 3> voxels{grid.voxels.x, grid.voxels.y, grid.voxels.z};
  const double cells = share * (voxels[axis] - 1);
  return {normal, dot(normal, grid.origin) + cells * dot(normal, column(edges, axis))};
}

void apply_slices(const SceneSlices& slices, const FirstVolume& first, RenderSettings& settings) {
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto& share = slices.along[axis];
    if (share) settings.slices.push_back(plane_across(axis, *share, first.grid));
  }
  if (slices.plane) settings.slices.push_back({slices.plane->normal, slices.plane->offset});
  settings.slice_low = slices.range ? slices.range->low : first.greys.low;
  settings.slice_high = slices.range ? slices.range->high : first.greys.high;
  settings.slices_mapped = slices.mapped;
  settings.slice_volume = 0;
}

}  // namespace

render::Camera camera_of(const SceneCamera& camera) {
  return {camera.target, camera.distance,      camera.azimuth,     camera.elevation,
          camera.roll,   camera.field_of_view, camera.orthographic};
}

std::string shown_field(const Scene& scene) {
  const SceneLook& look = scene.look;
  return look.colour_by == SceneColouring::field && look.field ? look.field->name : std::string();
}

void apply_scene(const Scene& scene, const ScenePicture& picture, RenderSettings& settings) {
  settings.clip_box_low = scene.clip.low;
  settings.clip_box_high = scene.clip.high;
  for (const ScenePlane& plane : scene.clip.planes) {
    settings.clip_planes.push_back({plane.normal, plane.offset});
  }
  settings.clip_caps = settings.clip_caps || scene.clip.caps;
  if (picture.first) apply_slices(scene.slices, *picture.first, settings);
  apply_look(scene.look, picture, settings);
  if (scene.background) settings.background = *scene.background;
}

}  // namespace isosplat
