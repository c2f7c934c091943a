#pragma once

#include <memory>
#include <string>

#include "native/builder/builder.h"
#include "native/builder/resampled_source.h"

// Fields on other voxels than those of their volume.
namespace isosplat {

/// Where the voxels of a field are.
struct FieldPlace {
  VolumeGrid grid;
  bool is_assumed = false;  ///< the voxels are taken for those of the volume
};

/// Finds the place of a field's voxels, by the grids that the files of volume and field state. If
/// one of them has probably stated no place, the field must have as many voxels as the volume, and
/// these are taken for those of the volume. `has_place`: the volume's file certainly states one.
/// Errors: invalid_argument; also if the field lies elsewhere.
Result<FieldPlace> find_field_place(const std::string& name, const VolumeGrid& volume,
                                    const VolumeGrid& field, bool has_place = false);

/// The field at the voxels of another grid: the field itself if all voxels are the same to a
/// hundredth of a voxel, else resampled. Errors: those of ResampledSource.
Result<std::unique_ptr<VolumeSource>> field_at_voxels(const std::string& name,
                                                      std::unique_ptr<VolumeSource> field,
                                                      const VolumeGrid& from, const VolumeGrid& to,
                                                      uint64_t memory_bytes,
                                                      const ResamplingOptions& options = {});

/// States how a field that was resampled from so many voxels differs from it. Errors: those of
/// ResampledSource::measure().
Result<std::string> resampling_note(ResampledSource& field, Index3 from);

}  // namespace isosplat
