#pragma once

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
  bool ends_early = false;        ///< the chain leads out of the file, or in a circle
  std::optional<double> no_data;  ///< GDAL's tag: voxels of this value have none
};

/// Errors: io_error, malformed_volume where there is not one whole directory.
Result<TiffPages> find_tiff_pages(const std::filesystem::path& path);

/// What a program wrote into a stack's description: how many pages stand for what, and sizes.
struct TiffDescription {
  bool is_imagej = false;
  std::optional<uint64_t> images;  ///< pages that there must be
  uint64_t slices = 1, channels = 1, frames = 1;
  bool frames_before_slices = false;  ///< the pages of one slice at all times follow each other
  std::string unit;                   ///< of lengths; empty: not said
  std::optional<double> between_slices;
  std::optional<Vec3d> voxel;  ///< OME-TIFF: the size of a voxel
};

/// Parses an ImageDescription. Errors: malformed_volume, unsupported_format for several images in
/// one file.
Result<TiffDescription> parse_tiff_description(const std::filesystem::path& path,
                                               std::string_view text);

}  // namespace isosplat
