#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "native/headless/grey_range.h"
#include "shared/core/categories/categories.h"
#include "shared/render/renderer.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat {

/// The volume of the first layer, whose values colours and slices of a scene show.
struct FirstVolume {
  VolumeGrid grid;           ///< in the scene
  double low = 0, high = 1;  ///< the range of its values
  GreyRange greys;           ///< black and white in slices
};

/// The values of a field on the surfaces of the first layer that has it.
using SceneFieldRange = std::array<double, 2>;

/// A scene whose visible layers are in the renderer.
struct ScenePicture {
  /// The isosurfaces of the visible layers, in order. A layer without surfaces gets one, at the
  /// first isovalue that its store suggests.
  std::vector<render::Isosurface> isosurfaces;
  std::optional<FirstVolume> first;  ///< nothing if the first layer is hidden
  /// Nothing if no visible layer has the field. The range of all of its values if there are none on
  /// the surfaces.
  std::optional<SceneFieldRange> field_range;
  std::vector<Category> categories;  ///< of the field, of all layers; empty: it has other values
  std::vector<std::string> fields;   ///< the names of the fields of the visible layers, each once
  VolumeGrid extent;                 ///< a grid around all visible layers, for default_camera()
  uint64_t samples = 0;              ///< of all layers
  uint32_t coarsest = 0;             ///< the coarsest of the levels that are drawn
  uint32_t layers = 0;               ///< number of visible layers
  std::vector<std::string> notes;    ///< about layers without isosurfaces
};

/// Uploads the visible layers of a scene at a step of time: layer i is volume i. The layers share
/// the samples evenly, and later layers may use the samples that earlier ones do not need. `field`:
/// of the stores, for ColourBy::field; empty: none. Errors: not_found (no such step or level, or no
/// layer is visible), those of SceneFile, open_field and show_store, which name the layer.
Result<ScenePicture> show_scene(render::Renderer& renderer, const SceneFile& scene, size_t step,
                                std::optional<uint32_t> level, uint64_t sample_budget,
                                const std::string& field);

/// The field that the look of a scene shows; empty: none.
std::string shown_field(const Scene& scene);

/// The camera of a scene.
render::Camera camera_of(const SceneCamera& camera);

/// Sets clipping, slices, look and background of a scene. Splats of the kind `automatic` are exact,
/// as in a picture at rest. The colours of a field extend over its range in the scene, or else
/// over `picture.field_range`, or [0, 1]; categories have their own colours.
void apply_scene(const Scene& scene, const ScenePicture& picture, render::RenderSettings& settings);

}  // namespace isosplat
