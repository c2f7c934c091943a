#pragma once

#include <array>
#include <optional>
#include <vector>

#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// A cell, or an octant of a subdivided cell. It has one sample, at its centre.
struct SampleBox {
  Vec3f low;                       ///< in cells, inside the unit cell
  float side = 1;                  ///< in cells
  std::array<float, 8> corners{};  ///< values of the trilinear function at the box's corners
};

/// The positions of the samples of a cell (paper, section 4).
enum class Subdivision : uint8_t {
  none,       ///< one sample for each active cell, like Isosplat
  isotropic,  ///< one for each active octant
  adaptive    ///< octants only where the interval is wider than a threshold
};

/// How a sample is projected (paper, section 3).
enum class ProjectionMethod : uint8_t {
  newton,          ///< one step; drops the sample if it is longer than half the box's diagonal
  newton_clamped,  ///< one step, clamped to this length and to the cell, like Isosplat
  two_newton,      ///< two steps; drops the sample if their sum is longer than this length
  exact  ///< the nearest root along the gradient in the cell; like newton_clamped if there is none
};

/// Computes the active boxes of a cell. `max_interval`: threshold of the adaptive subdivision.
/// Replaces `boxes`.
void subdivide(const std::array<float, 8>& corners, float isovalue, Subdivision subdivision,
               float max_interval, std::vector<SampleBox>& boxes);

/// The projection of a box's sample, in cells, or nothing if it is dropped.
std::optional<Vec3f> project_sample(const Trilinear& f, const SampleBox& box, float isovalue,
                                    ProjectionMethod method);

}  // namespace isosplat
