#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "shared/core/grid/volume_source.h"
#include "shared/import/tiff/file.h"

// Reads pages of TIFF files as slices.
namespace isosplat::import {

/// Checks that the page's compression can be decoded here. Errors: unsupported_format.
Result<void> check_decodable(const std::filesystem::path& path, const TiffPage& page);

/// Whether a voxel type is unsigned; only then does WhiteIsZero invert values.
bool is_unsigned(VoxelType type);

/// The error for a page that cannot be decoded. `where`: the file and page.
tl::unexpected<Error> damaged_tiff(const std::string& where);

/// The location of a slice. An empty path: the slice is missing, and its voxels are absent
/// (voxels/absent_voxels.h).
struct TiffSlice {
  std::filesystem::path path;
  uint64_t page = 0;  ///< offset of the page's directory
  TiffPart part = {};
};

/// A volume whose slices are the given pages, all of the kind `page`; `header` has the type of
/// `page`. `inverts`: voxels are unsigned, and 0 is stored as white. Strips and tiles that were not
/// written have the value `left_out`.
std::unique_ptr<VolumeSource> make_tiff_source(VolumeHeader header, TiffPage page,
                                               std::vector<TiffSlice> slices, bool inverts,
                                               double left_out);

}  // namespace isosplat::import
