#include "native/builder/field_place.h"

#include <fmt/format.h>

#include <algorithm>

#include "native/builder/field_build.h"
#include "native/builder/resampled_source.h"

namespace isosplat {
namespace {

Vec3d last_voxel(const VolumeGrid& grid) {
  return {grid.voxels.x - 1.0, grid.voxels.y - 1.0, grid.voxels.z - 1.0};
}

/// Whether two grids put a voxel at different places, by more than a hundredth of a voxel.
bool is_elsewhere(const VolumeGrid& a, const VolumeGrid& b, Vec3d index) {
  const double voxel = std::min({a.spacing.x, a.spacing.y, a.spacing.z});
  return !(length(a.world(index) - b.world(index)) <= voxel / 100);
}

/// Whether one of two files has probably not stated where its voxels are: it has the default grid,
/// or the grid of the other one at the default origin.
bool lacks_place(const VolumeGrid& a, const VolumeGrid& b) {
  const VolumeGrid none;
  const auto is_default = [&](const VolumeGrid& grid) {
    return grid.spacing == none.spacing && grid.origin == none.origin &&
           grid.direction == none.direction;
  };
  if (is_default(a) || is_default(b)) return true;
  if (a.voxels != b.voxels || (a.origin != none.origin && b.origin != none.origin)) return false;
  VolumeGrid moved = b;
  moved.origin = a.origin;
  return !is_elsewhere(a, moved, last_voxel(a));
}

bool is_same(const VolumeGrid& a, const VolumeGrid& b) {
  return a.voxels == b.voxels && !is_elsewhere(a, b, {}) && !is_elsewhere(a, b, last_voxel(a));
}

Result<std::string> resampling_note(ResampledSource& field, Index3 from) {
  const auto error = field.measure();
  if (!error) return tl::unexpected(error.error());
  if (error->outside == 1) {
    return fail(Status::invalid_argument,
                fmt::format("field '{}': expected values where the volume is, found none: its file "
                            "places it elsewhere",
                            field.header().name));
  }
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

}  // namespace

Result<FieldPlace> find_field_place(const std::string& name, const VolumeGrid& volume,
                                    const VolumeGrid& field) {
  if (is_same(volume, field) || !lacks_place(volume, field)) return FieldPlace{field};
  auto same = check_field_grid(name, volume.voxels, field.voxels);
  if (!same) return tl::unexpected(same.error());
  return FieldPlace{volume, true};
}

Result<std::unique_ptr<VolumeSource>> field_at_voxels(std::unique_ptr<VolumeSource> field,
                                                      const VolumeGrid& from, const VolumeGrid& to,
                                                      uint64_t memory_bytes, std::string* note) {
  if (is_same(from, to)) return field;
  auto resampled = ResampledSource::create(std::move(field), from, to, memory_bytes);
  if (!resampled) return tl::unexpected(resampled.error());
  if (note) {
    auto text = resampling_note(**resampled, from.voxels);
    if (!text) return tl::unexpected(text.error());
    *note = std::move(*text);
  }
  return std::move(*resampled);
}

}  // namespace isosplat
