#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/volume/segment_map.h"

namespace isosplat::import {

/// Opens a volume: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz), MRC (.mrc,
/// .map, .rec, also compressed), FreeSurfer's MGH (.mgh, .mgz), NumPy (.npy, .npz), HDF5, legacy
/// VTK structured points (.vtk), VTK's XML images (.vti, .pvti, .vtr, .pvtr), Gaussian cube, VASP,
/// XSF, OpenDX, TIFF (one file with pages, or a folder with a file per slice), a folder of PNG,
/// JPEG or JPEG 2000, DICOM (a folder with a series, or a multi-frame file), or raw voxels (with
/// dims and type in the options, or both in the file's name, as in head_256x256x128_uint8.raw). A
/// file of any of these may be compressed as a whole by gzip, bzip2, xz or Zstandard. Reads only
/// the header, and checks it against the file's size if the file is not compressed.
///
/// The result is the volume that the file describes; or that volume with notes about assumptions;
/// or an error. Data that are missing, truncated or contradictory are an error unless
/// options.allowed contains the matching allowance. shared/import/README.md describes the
/// conventions of each format.
///
/// Errors: io_error, unsupported_format, unsupported_type, malformed_volume, truncated, no_cells,
/// volume_too_large, invalid_argument (options that do not fit the file). The message contains the
/// file, what was expected and found, and the remedy.
Result<OpenVolume> open_volume(const std::filesystem::path& path, const ImportOptions& options);

/// Opens all segments of a DICOM segmentation: a file, or a folder with files of a series. Segments
/// that overlap are in different maps. options.segment chooses one segment. Empty if the path has
/// another format, or DICOM without a segmentation: open_volume reads it. The first map has the
/// notes. Errors: those of open_volume.
Result<std::vector<SegmentMap>> open_segments(const std::filesystem::path& path,
                                              const ImportOptions& options);

/// The format of a file by its first bytes and its name: "NRRD", "MetaImage", "NIfTI", "MGH",
/// "MRC", "NumPy", "NumPy archive", "HDF5", "netCDF" (its classic format), "VTK", "VTK XML",
/// "cube", "VASP", "XSF", "OpenDX", "TIFF", "DICOM", "raw" or "compressed"; empty if no reader
/// supports it. Reads no headers, so open_volume may still refuse the file.
std::string_view format_of_file(const std::filesystem::path& path);

/// The compression of a file as a whole, if open_volume decompresses it before its reader reads it:
/// "gzip", "bzip2", "xz" or "zstd"; else empty. In WebAssembly the caller decompresses it.
std::string_view packing_of_file(const std::filesystem::path& path);

/// The volumes of a file or folder that has several (HDF5: its datasets; TIFF: images), in order.
/// Empty if open_volume needs no choice for this file. DICOM: each of its series, also a single
/// one, since the names of its files do not describe it. Errors: those of open_volume.
Result<std::vector<VolumeChoice>> volumes_in_file(const std::filesystem::path& path);

}  // namespace isosplat::import
