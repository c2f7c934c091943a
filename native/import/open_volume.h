#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "native/import/volume_source.h"

namespace isosplat {

/// What a person may say of a volume that its file does not, or says wrongly.
struct ImportOptions {
  std::optional<Vec3<int64_t>> dims;  ///< raw files only: voxels along x, y, z
  std::optional<VoxelType> type;      ///< raw files only
  bool big_endian = false;            ///< raw files only
  uint64_t skip_bytes = 0;            ///< raw files only: before the first voxel
  std::optional<Vec3d> spacing;       ///< every format: instead of the header's
  std::optional<int64_t> time_step;   ///< of a 4D volume, from 0
};

/// An open volume, and what a person should know of how it was read (one sentence each).
struct OpenVolume {
  std::unique_ptr<VolumeSource> source;
  std::vector<std::string> notes;
};

/// Opens a volume: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz), legacy VTK
/// structured points (.vtk), TIFF (one file with pages, or a folder with a file per slice), DICOM
/// (a folder with a series, or a multi-frame file), or raw voxels (with dims and type, or with
/// both in the file's name, as in head_256x256x128_uint8.raw). Reads the header only, and has
/// checked it against the file's size where the file is not compressed.
///
/// Errors: io_error, unsupported_format, unsupported_type, malformed_volume, truncated, no_cells,
/// volume_too_large, invalid_argument (options that do not fit the file); the message names the
/// file, what was expected and found, and the remedy.
Result<OpenVolume> open_volume(const std::filesystem::path& path, const ImportOptions& options);

/// The voxel type of a name as the command line and raw file names write it: u8, uint8, uchar, i16,
/// int16, short, f32, float, … Nothing for an unknown one.
std::optional<VoxelType> voxel_type_of(std::string_view name);

}  // namespace isosplat
