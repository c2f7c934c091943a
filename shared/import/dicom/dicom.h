#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/volume/segment_map.h"

namespace isosplat::import {

/// Bytes that are read to recognize DICOM.
inline constexpr size_t kDicomBeginning = 256;

/// Whether the first bytes of a file, up to kDicomBeginning of them, are those of DICOM.
bool is_dicom(std::string_view beginning);

/// Whether the file at a path begins as DICOM. False if it cannot be read.
bool is_dicom_file(const std::filesystem::path& path);

/// Opens a file with several frames. Errors: those of open_volume.
Result<OpenVolume> open_dicom_file(const std::filesystem::path& path, const ImportOptions& options);

/// Opens a folder with the files of a series. Errors: those of open_volume.
Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);

/// The volumes of a file or folder, as choices of the option --series: one for each stack of
/// slices. Errors: those of open_volume.
Result<std::vector<VolumeChoice>> dicom_volumes(const std::filesystem::path& path);

/// Opens the segmentation in a file or folder, and leaves out images beside it: see open_segments.
/// Empty if there is none. Errors: those of open_volume.
Result<std::vector<SegmentMap>> open_dicom_segments(const std::filesystem::path& path,
                                                    const ImportOptions& options);

}  // namespace isosplat::import
