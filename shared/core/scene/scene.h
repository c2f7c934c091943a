#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/base/vec3.h"
#include "shared/core/grid/grid.h"

// Scenes: lists of layers that one picture shows (SCENE.md).
namespace isosplat {

/// An affine transform of the world, row by row: its last row is 0 0 0 1.
using AffineTransform = std::array<double, 16>;

struct SceneSurface {
  double isovalue = 0;                         ///< in the values of the layer's store
  std::optional<std::array<float, 3>> colour;  ///< sRGB, 0 … 1; default: that of its number
  float opacity = 1;                           ///< 0 … 1
};

/// The label of a segmentation whose surface a layer shows, for people and other programs.
struct SceneLabel {
  int64_t value = 0;    ///< in the file of labels; at most ±2^53
  uint64_t voxels = 0;  ///< with this value; at most 2^53
  double volume = 0;    ///< of these voxels, in cubic units of the world
};

/// A store with its surfaces and its place in the world.
struct SceneLayer {
  std::string name;   ///< for people; may be empty
  std::string group;  ///< for people: layers of a group are listed together; may be empty
  /// Layers with the same text show parts of one volume, with the same surfaces; may be empty.
  std::string part_of;
  /// One, or one for each step of time: paths or addresses relative to the scene.
  std::vector<std::string> stores;
  std::vector<SceneSurface> surfaces;  ///< at most kMaxSurfacesOfLayer
  bool visible = true;
  std::optional<AffineTransform> transform;
  std::optional<SceneLabel> label;
};

/// The steps of a scene that changes with time.
struct SceneTime {
  std::vector<double> values;  ///< ascending, one for each step
  std::string unit;            ///< may be empty
  size_t step = 0;             ///< shown first: an index of `values`
};

struct SceneCamera {
  Vec3d target;                                                       ///< world
  double distance = 1;                                                ///< world units
  double azimuth = 30, elevation = 20, roll = 0, field_of_view = 30;  ///< degrees
  bool orthographic = false;
};

struct ScenePlane {
  Vec3d normal;  ///< world; not 0
  double offset = 0;
};

struct SceneClip {
  Vec3d low{0, 0, 0}, high{1, 1, 1};  ///< fractions of the extent of the first layer's volume
  std::vector<ScenePlane> planes;     ///< each keeps dot(normal, position) ≥ offset
  bool caps = false;
};

/// Planes that show the values of the first layer.
struct SceneSlices {
  struct Range {
    double low = 0, high = 1;
  };
  /// Across x, y and z: fractions of the extent of the first layer's volume.
  std::array<std::optional<double>, 3> along;
  std::optional<ScenePlane> plane;  ///< an oblique one
  std::optional<Range> range;  ///< the values that are black and white; default: those of the store
  bool mapped = false;         ///< in the colours of the look's map instead of greys
};

enum class SceneSplats : uint8_t { automatic, quad, ellipse, exact };
enum class SceneShading : uint8_t { smooth, exact };
enum class SceneColouring : uint8_t {
  isosurface,
  isovalue,
  gradient,
  depth,
  level,
  projection_error,
  field,
};
enum class SceneColourMap : uint8_t { viridis, magma, cividis, turbo };

enum class SceneFieldScale : uint8_t { linear, logarithmic, symmetric };

/// The field of stores that colours show. Stores without it have the colours of their surfaces.
struct SceneField {
  struct Range {
    double low = 0, high = 1;
  };
  std::string name;  ///< 1 to kMaxSceneFieldName bytes
  /// The values of the first and the last colour, both above 0 for a logarithmic scale; default:
  /// those on the surfaces of the first layer that has the field.
  std::optional<Range> range;
  SceneFieldScale scale = SceneFieldScale::linear;
  int steps = 0;  ///< number of colours, 2 to kMaxSceneFieldSteps; 0: all of the map
  /// Distance of contour lines, in values; of their logarithms to base 10 for a logarithmic scale.
  /// 0: no lines.
  double lines = 0;
};

/// The light, and the material of surfaces: the numbers of render::LightSettings. Absent ones have
/// the defaults there.
struct SceneLight {
  std::optional<double> azimuth, elevation;  ///< of the key light, in degrees
  std::optional<double> key, sky, rim, highlight, roughness, occlusion, occlusion_radius, shadow,
      shadow_softness;
};

/// How surfaces look. Absent members have the viewer's defaults.
struct SceneLook {
  std::optional<SceneSplats> kind;
  std::optional<SceneShading> shading;
  std::optional<SceneColouring> colour_by;
  std::optional<SceneColourMap> colour_map;
  std::optional<SceneField> field;  ///< shown with SceneColouring::field, which requires it
  SceneLight light;
  std::optional<double> eye_dome;  ///< strength of edge shading, 0 … 1
};

enum class SceneMeasurementKind : uint8_t { point, distance, path, angle, note };

/// The value of a field at a point, measured while colours showed the field.
struct SceneMeasuredField {
  std::string name, units;
  double value = 0;
};

struct SceneMeasuredPoint {
  Vec3d position;                 ///< world
  std::optional<double> value;    ///< of the volume at this point
  std::optional<Vec3d> normal;    ///< world, of unit length
  std::optional<uint64_t> level;  ///< of the cell that was measured: at 0 the point is exact
  std::string layer;              ///< the title of the layer, if there were several
  std::optional<Vec3d> voxel;     ///< in the volume of this layer
  std::optional<SceneMeasuredField> field;
};

struct SceneMeasurement {
  SceneMeasurementKind kind = SceneMeasurementKind::point;
  std::vector<SceneMeasuredPoint> points;
  std::string text;  ///< a name, or the text of a note
};

/// A scene, without the unknown members of its document. A program that changes a document must
/// keep these.
struct Scene {
  std::string name;
  std::vector<SceneLayer> layers;  ///< at least one
  std::optional<SceneTime> time;
  std::optional<SceneCamera> camera;
  SceneClip clip;
  SceneSlices slices;
  SceneLook look;
  std::optional<std::array<float, 4>> background;  ///< sRGB with alpha
  std::vector<SceneMeasurement> measurements;
};

inline constexpr size_t kMaxSceneBytes = size_t{4} << 20;
inline constexpr size_t kMaxLayers = 4096;
inline constexpr size_t kMaxSurfacesOfLayer = 8;
inline constexpr size_t kMaxSteps = 65536;
inline constexpr size_t kMaxScenePlanes = 6;
inline constexpr size_t kMaxSceneFieldName = 64;
inline constexpr int kMaxSceneFieldSteps = 256;
inline constexpr size_t kMaxMeasurements = 500;
inline constexpr size_t kMaxMeasuredPath = 500;      ///< points of one path
inline constexpr size_t kMaxMeasuredPoints = 10000;  ///< of all measurements

/// Reads the text of a scene (SCENE.md). Unknown members are ignored. Errors: malformed_header,
/// which names the member, what was expected and what was found; unsupported_version.
Result<Scene> parse_scene(std::string_view text);

/// Whether bytes begin as a scene does: text, and a JSON object. It serves to choose a reader;
/// parse_scene decides whether the scene is valid.
bool looks_like_scene(std::string_view first_bytes);

/// Whether a store's path stays below the folder of its scene: relative, without "..", and the same
/// on all systems. Only such stores are put into bundles.
bool is_path_below(std::string_view path);

/// The step that a scene shows first; 0 without time.
inline size_t first_step(const Scene& scene) {
  return scene.time ? scene.time->step : 0;
}

/// The store that a layer shows at a step of its scene.
inline const std::string& store_at(const SceneLayer& layer, size_t step) {
  return layer.stores[std::min(step, layer.stores.size() - 1)];
}

/// The paths of all stores of a scene, each once: by steps, from the one that is shown first to the
/// last, then from step 0.
std::vector<std::string> store_paths(const Scene& scene);

/// The grid of a volume after an affine transform of the world. Errors: invalid_argument if the
/// axes of the result lie nearly in a plane (is_basis).
Result<VolumeGrid> transformed(const VolumeGrid& grid, const AffineTransform& transform);

}  // namespace isosplat
