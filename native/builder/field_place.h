#pragma once

#include <memory>
#include <string>

#include "native/builder/builder.h"

// Fields on other voxels than those of their volume.
namespace isosplat {

/// Where the voxels of a field are.
struct FieldPlace {
  VolumeGrid grid;
  bool is_assumed = false;  ///< the voxels are taken for those of the volume
};

/// Finds the place of a field's voxels, by the grids that the files of volume and field state. If
/// one of them has probably stated no place, the field must have as many voxels as the volume, and
/// these are taken for those of the volume. Errors: invalid_argument.
Result<FieldPlace> find_field_place(const std::string& name, const VolumeGrid& volume,
                                    const VolumeGrid& field);

/// The field at the voxels of another grid: the field itself if all voxels are the same to a
/// hundredth of a voxel, else resampled. `note`: if not null, receives how the resampled field
/// differs from the field. Errors: those of ResampledSource; with `note`, invalid_argument if the
/// field has no values there.
Result<std::unique_ptr<VolumeSource>> field_at_voxels(std::unique_ptr<VolumeSource> field,
                                                      const VolumeGrid& from, const VolumeGrid& to,
                                                      uint64_t memory_bytes,
                                                      std::string* note = nullptr);

}  // namespace isosplat
