#pragma once

#include <string>
#include <string_view>

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// A file format: the functions that recognize and open it. Functions that a format does not need
/// are null.
struct Format {
  std::string_view name;        ///< as format_of_file returns it
  std::string_view title = {};  ///< in the list of formats that errors give; empty: not listed
  int title_rank = 0;           ///< in that list, from 1
  bool reads_gzip =
      false;  ///< by itself: files of other formats are decompressed before they are read
  bool has_header = true;  ///< options of raw files are then not used

  /// Whether a file's first bytes, decompressed, are those of the format.
  bool (*begins)(std::string_view head) = nullptr;
  /// Whether the name of a file, or of one beside it, belongs to the format, and the first bytes do
  /// not contradict it. `is_raw`: the options describe raw voxels.
  bool (*is_named)(const FileHead& head, bool is_raw) = nullptr;
  /// Whether the first bytes may belong to the format. For formats without a signature.
  bool (*resembles)(const FileHead& head) = nullptr;
  /// Errors: those of open_volume.
  Result<OpenVolume> (*open)(const FileHead& head, const ImportOptions& options) = nullptr;
};

/// The format of a file; null if no reader supports it. First bytes take precedence over names.
/// `is_raw`: the options describe raw voxels.
const Format* format_of(const FileHead& head, bool is_raw);

/// "NRRD, MetaImage, … or legacy VTK".
std::string titles_of_formats();

}  // namespace isosplat::import
