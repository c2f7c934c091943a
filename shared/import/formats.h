#pragma once

#include <filesystem>

#include "shared/import/open_volume.h"

// One function per format. Each opens a file or folder whose format open_volume has detected. All
// have the same options and errors as open_volume.
namespace isosplat {

Result<OpenVolume> open_nrrd(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_meta_image(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_nifti(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_mrc(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_npy(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_hdf5(const std::filesystem::path& path, const ImportOptions& options);
/// The error of netCDF's own format, which is not that of HDF5: how to convert it.
Result<OpenVolume> refuse_netcdf_classic(const std::filesystem::path& path,
                                         const ImportOptions& options);
Result<OpenVolume> open_vtk_legacy(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options);
/// The volumes of a TIFF file, or of the OME-TIFF in a folder. Empty if it needs no choice.
Result<std::vector<VolumeChoice>> tiff_volumes(const std::filesystem::path& path);
Result<OpenVolume> open_dicom_file(const std::filesystem::path& path, const ImportOptions& options);
Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);
/// A folder with a picture per slice: PNG, JPEG or JPEG 2000.
Result<OpenVolume> open_image_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);
/// The bytes of a folder's pictures of one format; 0 if it has fewer than two.
uint64_t image_bytes_of_folder(const std::filesystem::path& folder);
/// Whether the first bytes of a file are those of MRC; `by_name`: the file's name is one of MRC, so
/// that the text "MAP " may be missing, as in files from before 2000.
bool is_mrc(std::string_view beginning, bool by_name);
/// Whether the first 4096 bytes of a file have HDF5's signature, perhaps after a user block.
bool is_hdf5(std::string_view beginning);
/// Whether the first bytes of a file are those of DICOM.
bool is_dicom(const std::filesystem::path& path);
Result<OpenVolume> open_raw(const std::filesystem::path& path, const ImportOptions& options);

/// Whether a raw file's name contains its dims and type.
bool raw_name_is_complete(const std::filesystem::path& path);

/// A file name without folder and suffixes: "a/b.nii.gz" → "b".
std::string volume_name(const std::filesystem::path& path);

/// Selects a time step of a volume with `sizes` along its axes (fastest first; trailing axes of
/// size 1 are ignored). Returns 0 for a volume without a time axis. Errors: no_cells for 2D,
/// unsupported_format for more than 4 axes, invalid_argument for a 4D volume without a valid time
/// step, or for a time step of a volume without a time axis.
Result<uint64_t> choose_time_step(const std::filesystem::path& path,
                                  const std::vector<int64_t>& sizes, const ImportOptions& options);

/// Selects one of `steps` volumes by the options; 0 if there is only one. Errors: invalid_argument
/// if there are several and --time-step is missing or out of range.
Result<uint64_t> choose_step(const std::filesystem::path& path, int64_t steps,
                             const ImportOptions& options);

/// The error for a volume whose voxels are vectors or colours.
tl::unexpected<Error> not_scalar(const std::filesystem::path& path, int components);

/// The error for voxels of an unsupported type.
tl::unexpected<Error> unknown_type(const std::filesystem::path& path, std::string_view type);

}  // namespace isosplat
