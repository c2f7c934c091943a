#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/tiff/file.h"
#include "shared/import/tiff/pages.h"
#include "shared/import/volume/volume_choices.h"

// The order of a TIFF file's pages, from its metadata.
namespace isosplat::import {

/// The axes of a stack in addition to x and y.
enum class TiffAxis : uint8_t { z, channel, time };

/// Pages of an OME-TIFF: the `count` pages of a file from page `page` on are consecutive planes of
/// the series, from `first` on.
struct OmePages {
  std::string file;                 ///< its name; empty: the file with the description
  std::string uuid;                 ///< of that file; empty: unknown
  std::array<uint64_t, 3> first{};  ///< z, channel, time
  uint64_t page = 0, count = 1;
};

/// One image of a file: its planes along the axes z, channel and time.
struct TiffSeries {
  std::string name;
  std::array<uint64_t, 3> sizes{1, 1, 1};  ///< by TiffAxis
  /// The axes in the order of the pages: the first one changes with each page, the last one is
  /// slowest.
  std::array<TiffAxis, 3> order{TiffAxis::channel, TiffAxis::z, TiffAxis::time};
  std::vector<ChannelDescription> channels;
  double time_distance = 0;  ///< between steps; 0: not stated
  std::string time_unit;
  std::optional<TiffAxis> in_samples;  ///< the axis of the samples of each pixel; mostly channels
  bool depth_is_z = false;             ///< the slices are those of pages with a depth
  /// The axis of time has no name, and may be another one. If it has this size, the axis of z may
  /// be one of channels.
  bool unnamed = false;

  uint64_t first_page = 0;    ///< in TiffPages::offsets
  uint64_t pages = 0;         ///< number of pages that it has, or should have
  bool counted = false;       ///< the description states the number of pages
  bool follow = false;        ///< the planes follow the first one, without separate directories
  std::vector<OmePages> ome;  ///< OME-TIFF: the locations of the planes
  std::string ome_uuid;       ///< of the file with the description
  std::optional<int64_t> width, height;  ///< stated by the description

  /// Distances along x, y and z in `units`; nothing: not stated. An empty unit is unknown.
  std::array<std::optional<double>, 3> lengths;
  std::array<std::string, 3> units;
  /// Value = intercept + slope · voxel.
  double slope = 1, intercept = 0;
  std::vector<std::string> notes;

  uint64_t size(TiffAxis axis) const { return sizes[static_cast<size_t>(axis)]; }
  uint64_t& size(TiffAxis axis) { return sizes[static_cast<size_t>(axis)]; }
};

/// The number of a page in the order of the series; a page has all its samples and slices.
uint64_t plane_number(const TiffSeries& series, uint64_t z, uint64_t channel, uint64_t time);

/// The series of a file by its first page and description: OME-XML, ImageJ, SCIFIO, tifffile,
/// MetaMorph, LSM, GDAL, or none of them (runs of pages of the same size and type). Returns at
/// least one. Errors: malformed_volume, unsupported_format; io_error.
Result<std::vector<TiffSeries>> tiff_series(const std::filesystem::path& path,
                                            const TiffPages& pages, const TiffPage& first);

// The parts of tiff_series. Each returns nothing if the file is of another kind.

using TiffSeriesList = Result<std::vector<TiffSeries>>;

/// OME-XML of the file `path` (ome.cpp). Reads a companion file if the text names one.
TiffSeriesList ome_series(const std::filesystem::path& path, std::string_view text);
bool is_ome(std::string_view text);

/// The lines of ImageJ and SCIFIO (imagej.cpp).
TiffSeriesList imagej_series(const std::filesystem::path& path, const TiffPages& pages,
                             const TiffPage& first);
bool is_imagej(std::string_view text);

/// tifffile's JSON (shaped.cpp).
TiffSeriesList shaped_series(const std::filesystem::path& path, const TiffPages& pages,
                             const TiffPage& first);
bool is_shaped(std::string_view text);

/// MetaMorph's stack of planes behind one directory (metamorph.cpp).
TiffSeriesList metamorph_series(const std::filesystem::path& path, const TiffPages& pages,
                                const TiffPage& first);

/// Zeiss LSM (lsm.cpp).
TiffSeriesList lsm_series(const std::filesystem::path& path, const TiffPages& pages,
                          const TiffPage& first);

}  // namespace isosplat::import
