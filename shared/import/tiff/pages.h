#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/tiff/directory.h"

namespace isosplat::import {

/// The properties that distinguish pages of one image from those of another.
struct TiffPageKind {
  uint64_t width = 0, height = 0, depth = 1, bits = 1, format = 1, samples = 1;
  bool operator==(const TiffPageKind&) const = default;
};

/// A page that is not a copy.
struct TiffPageEntry {
  TiffPageKind kind;
  std::optional<TiffEntry> description;
};

/// The pages of a TIFF file, found by following its chain of directories.
struct TiffPages {
  bool big_endian = false;
  std::vector<uint64_t> offsets;       ///< of each page's directory
  std::vector<TiffPageEntry> entries;  ///< of the same pages
  std::vector<uint64_t> chain;         ///< of all directories, including those of copies
  size_t left_out = 0;                 ///< pages that are smaller copies or masks of others
  size_t left_out_parts = 0;  ///< strips and tiles that were not written: sparse files of GDAL
  bool ends_early = false;    ///< the chain of directories leaves the file, or has a cycle

  std::optional<double> no_data;  ///< GDAL's tag: voxels of this value are absent
  std::string gdal_metadata;      ///< GDAL's tag with XML
  /// Entries of the first page. MetaMorph: tags 33628 to 33631; LSM: tag 34412.
  std::optional<TiffEntry> uic1, uic2, uic3, uic4, lsm;
};

/// Errors: io_error, malformed_volume if no directory is complete.
Result<TiffPages> find_tiff_pages(const std::filesystem::path& path);

}  // namespace isosplat::import
