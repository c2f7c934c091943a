#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/grid.h"

namespace isosplat {

/// The pages of a TIFF file, found by following its chain of directories.
struct TiffPages {
  bool big_endian = false;
  std::vector<uint64_t> offsets;  ///< of each page's directory
  size_t left_out = 0;            ///< pages that are smaller copies or masks of others
  bool ends_early = false;        ///< the chain of directories leaves the file, or is a cycle
  std::optional<double> no_data;  ///< GDAL's tag: voxels of this value are absent
};

/// Errors: io_error, malformed_volume if no directory is complete.
Result<TiffPages> find_tiff_pages(const std::filesystem::path& path);

/// The description of a stack that a program wrote: the meaning of its pages, and sizes.
struct TiffDescription {
  bool is_imagej = false;
  std::optional<uint64_t> images;  ///< the expected number of pages
  uint64_t slices = 1, channels = 1, frames = 1;
  bool frames_before_slices = false;  ///< the pages of one slice at all times are consecutive
  std::array<std::string, 3> units;   ///< of lengths along x, y and z; empty: unknown
  std::optional<double> between_slices;
  std::optional<Vec3d> voxel;  ///< OME-TIFF: the size of a voxel
  /// OME-TIFF: the size of a page.
  std::optional<int64_t> width, height;
  /// ImageJ's calibration of values: value = intercept + slope · voxel. ImageJ stores signed 16-bit
  /// voxels as unsigned ones with the intercept −32768.
  double slope = 1, intercept = 0;
  std::vector<std::string> notes;
};

/// Parses the description that ImageJ or an OME program wrote into the first page. Errors:
/// malformed_volume, unsupported_format for several images in one file, and for pages in another
/// order than DimensionOrder's.
Result<TiffDescription> parse_tiff_description(const std::filesystem::path& path,
                                               std::string_view text);

}  // namespace isosplat
