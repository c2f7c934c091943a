#pragma once

#include <filesystem>

#include "native/import/open_volume.h"

// One function per format: each opens a file or folder that open_volume has found to be of its
// kind. All take the same options and give the same errors as open_volume.
namespace isosplat {

Result<OpenVolume> open_nrrd(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_meta_image(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_nifti(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_vtk_legacy(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options);
Result<OpenVolume> open_dicom_file(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);
/// Whether a file is DICOM by its first bytes.
bool is_dicom(const std::filesystem::path& path);
Result<OpenVolume> open_raw(const std::filesystem::path& path, const ImportOptions& options);

/// Whether a raw file's name holds its dims and type.
bool raw_name_is_complete(const std::filesystem::path& path);

/// A name without folder and suffixes: "a/b.nii.gz" → "b".
std::string volume_name(const std::filesystem::path& path);

/// One time step of a volume with `sizes` along its axes (fastest first; trailing ones of 1 do not
/// count): which one, 0 for a volume without time. Errors: no_cells for 2D, unsupported_format for
/// more than 4 axes, invalid_argument for a 4D volume without a valid time step, or a time step for
/// a volume without time.
Result<uint64_t> choose_time_step(const std::filesystem::path& path,
                                  const std::vector<int64_t>& sizes, const ImportOptions& options);

/// Which of `steps` volumes options choose, 0 where there is one. Errors: invalid_argument for
/// several without a --time-step, or one that is not there.
Result<uint64_t> choose_step(const std::filesystem::path& path, int64_t steps,
                             const ImportOptions& options);

/// The error for a volume whose voxels are vectors or colours.
tl::unexpected<Error> not_scalar(const std::filesystem::path& path, int components);

/// The error for voxels of a type that is not read.
tl::unexpected<Error> unknown_type(const std::filesystem::path& path, std::string_view type);

}  // namespace isosplat
