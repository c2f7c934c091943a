#pragma once

#include <array>

#include "shared/core/unstructured/mesh.h"

namespace isosplat {

/// Whether a triangle and a box have a common point, by the separating axes (Akenine-Möller, "Fast
/// 3D triangle-box overlap testing", 2001).
bool overlap(const Box& box, const std::array<Vec3d, 3>& triangle);

}  // namespace isosplat
