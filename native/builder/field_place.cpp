#include "native/builder/field_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "native/builder/field_build.h"

namespace isosplat {
namespace {

/// Voxel (0, 0, 0), and the last voxel along each axis. They determine the places of all.
std::array<Vec3d, 4> outer_voxels(const VolumeGrid& grid) {
  return {{{0, 0, 0},
           {grid.voxels.x - 1.0, 0, 0},
           {0, grid.voxels.y - 1.0, 0},
           {0, 0, grid.voxels.z - 1.0}}};
}

/// Whether two grids have the same voxels, to a hundredth of a voxel.
bool is_same(const VolumeGrid& a, const VolumeGrid& b) {
  const double most = std::min({a.spacing.x, a.spacing.y, a.spacing.z}) / 100;
  const auto outer = outer_voxels(a);
  return a.voxels == b.voxels && std::all_of(outer.begin(), outer.end(), [&](Vec3d index) {
           return length(a.world(index) - b.world(index)) <= most;
         });
}

bool is_default(const VolumeGrid& grid) {
  const VolumeGrid none;
  return grid.spacing == none.spacing && grid.origin == none.origin &&
         grid.direction == none.direction;
}

/// Whether one of two files has probably not stated where its voxels are: it has the default grid,
/// or the grid of the other one at the default origin.
bool lacks_place(const VolumeGrid& a, const VolumeGrid& b) {
  const Vec3d none{0, 0, 0};
  if (is_default(a) || is_default(b)) return true;
  if (a.origin != none && b.origin != none) return false;
  VolumeGrid moved = b;
  moved.origin = a.origin;
  return is_same(a, moved);
}

/// Whether the box of a grid, with half a voxel around it, overlaps that of another along the axes
/// of this one.
bool overlaps(const VolumeGrid& grid, const VolumeGrid& other) {
  const double infinity = std::numeric_limits<double>::infinity();
  Vec3d low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d index{corner & 1 ? other.voxels.x - 0.5 : -0.5,
                      corner & 2 ? other.voxels.y - 0.5 : -0.5,
                      corner & 4 ? other.voxels.z - 0.5 : -0.5};
    const Vec3d at = multiply_transposed(grid.dual_edges(), other.world(index) - grid.origin);
    low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
  }
  const Index3 n = grid.voxels;
  return low.x < n.x - 0.5 && low.y < n.y - 0.5 && low.z < n.z - 0.5 && high.x > -0.5 &&
         high.y > -0.5 && high.z > -0.5;
}

}  // namespace

Result<FieldPlace> find_field_place(const std::string& name, const VolumeGrid& volume,
                                    const VolumeGrid& field, bool has_place) {
  if (is_same(volume, field)) return FieldPlace{field};
  if (!(has_place ? is_default(field) : lacks_place(volume, field))) {
    if (overlaps(volume, field) && overlaps(field, volume)) return FieldPlace{field};
    return fail(Status::invalid_argument,
                fmt::format("field '{}': expected values where the volume is, found none: its file "
                            "places it elsewhere",
                            name));
  }
  if (auto same = check_field_grid(name, volume.voxels, field.voxels); !same) {
    return fail(same.error().status,
                same.error().message +
                    ", since one of the files states no place (its spacing is 1, its origin 0)");
  }
  return FieldPlace{volume, true};
}

Result<std::unique_ptr<VolumeSource>> field_at_voxels(const std::string& name,
                                                      std::unique_ptr<VolumeSource> field,
                                                      const VolumeGrid& from, const VolumeGrid& to,
                                                      uint64_t memory_bytes,
                                                      const ResamplingOptions& options) {
  if (is_same(from, to)) return field;
  auto resampled = ResampledSource::create(name, std::move(field), from, to, memory_bytes, options);
  if (!resampled) return tl::unexpected(resampled.error());
  return std::move(*resampled);
}

Result<std::string> resampling_note(ResampledSource& field, Index3 from) {
  const auto error = field.measure();
  if (!error) return tl::unexpected(error.error());
  std::string text = fmt::format(
      "resampled from {} × {} × {} voxels to those of the volume: at random points, values differ "
      "from the field's by at most {:.3g}, RMS {:.2g}",
      from.x, from.y, from.z, error->max, error->rms);
  if (error->outside > 0) {
    text += fmt::format("; about {:.1f} % of the volume have no value of the field",
                        100 * error->outside);
  }
  return text;
}

}  // namespace isosplat
