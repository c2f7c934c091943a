#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/scene/scene.h"
#include "shared/core/store/store_reader.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat {

/// Colours of isosurfaces in order: bone and skin, then those of Okabe and Ito (2008), which people
/// with colour vision deficiency can distinguish.
inline constexpr std::array<Vec3f, 8> kSurfaceColours{{{0.90f, 0.85f, 0.74f},
                                                       {0.84f, 0.55f, 0.42f},
                                                       {0.34f, 0.71f, 0.91f},
                                                       {0.00f, 0.62f, 0.45f},
                                                       {0.94f, 0.89f, 0.26f},
                                                       {0.00f, 0.45f, 0.70f},
                                                       {0.84f, 0.37f, 0.00f},
                                                       {0.80f, 0.47f, 0.65f}}};

/// The first suggested isovalue of a store. Nothing if its metadata, which are not trusted, have
/// none.
std::optional<double> suggested_isovalue(const StoreInfo& info);

/// The surfaces of a layer, all with colours: those of the scene, or else one at the first isovalue
/// that the store suggests, or none. `number`: of the layer among those that are visible; it
/// chooses the colours that the scene does not state.
std::vector<SceneSurface> surfaces_of(const SceneLayer& layer, const StoreInfo& info,
                                      size_t number);

/// A layer for messages: "layer 2 (bone)".
std::string name_of(const Scene& scene, size_t layer);

/// An error with the name of its layer in front.
Error with_layer(const Scene& scene, size_t layer, Error error);

/// The note about a layer for which surfaces_of() returns nothing.
std::string no_surfaces(const Scene& scene, size_t layer);

/// The store of a layer at a step of time, and where its volume lies after the layer's transform.
struct OpenedLayer {
  std::shared_ptr<StoreFile> store;
  VolumeGrid grid;
};

/// Opens the store of a layer. A layer with one store has it at all steps. Errors: those of
/// SceneFile::open_store and transformed(), which name the layer.
Result<OpenedLayer> open_layer(const SceneFile& scene, size_t layer, size_t step);

/// Errors: not_found if a scene has no such step of time.
Result<void> check_step(const Scene& scene, size_t step);

}  // namespace isosplat
