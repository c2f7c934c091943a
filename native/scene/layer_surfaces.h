#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/scene/scene.h"
#include "shared/core/store/store_reader.h"

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

}  // namespace isosplat
