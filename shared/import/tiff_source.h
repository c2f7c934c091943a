#pragma once

#include <tiffio.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "shared/grid/volume_source.h"

// Reads pages of TIFF files as slices; libtiff decodes them.
namespace isosplat {

using TiffHandle = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

/// Null if libtiff cannot open the file. Its messages are discarded.
TiffHandle open_tiff(const std::filesystem::path& path);

/// The pixels of a file's current page.
struct TiffPage {
  int64_t width = 0;
  int64_t height = 0;
  VoxelType type = VoxelType::u8;
  int samples = 1;
  bool white_is_zero = false;
  bool palette = false;
  uint16_t orientation = ORIENTATION_TOPLEFT;
  std::string unknown;  ///< why VoxelType does not have the type; empty: it does

  bool same_kind(const TiffPage& other) const {
    return width == other.width && height == other.height && type == other.type &&
           samples == other.samples && white_is_zero == other.white_is_zero &&
           orientation == other.orientation && unknown == other.unknown;
  }
};

TiffPage describe_page(TIFF* tiff);

/// Whether all strips or tiles of the current page lie inside the file.
bool is_whole_page(TIFF* tiff, uint64_t file_bytes);

/// Whether a voxel type is unsigned; only then does WhiteIsZero invert values.
bool is_unsigned(VoxelType type);

/// The error for a page that cannot be decoded. `where`: the file and page.
tl::unexpected<Error> damaged_tiff(const std::string& where);

/// Position of a slice. An empty path: the slice is missing, its voxels are absent
/// (absent_voxels.h).
struct TiffSlice {
  std::filesystem::path path;
  uint64_t page = 0;  ///< offset of the page's directory
};

/// A volume whose slices are the given pages, all of the kind `page`; `header` has the type of
/// `page`.
std::unique_ptr<VolumeSource> make_tiff_source(VolumeHeader header, TiffPage page,
                                               std::vector<TiffSlice> slices);

}  // namespace isosplat
