#pragma once

#include <string>
#include <string_view>

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// A format of files: what tells it, and what opens it. A function that a format does not need is
/// null.
struct Format {
  std::string_view name;        ///< as format_of_file returns it
  std::string_view title = {};  ///< in the list of formats that errors give; empty: not listed
  int title_rank = 0;           ///< in that list, from 1
  bool reads_gzip = false;      ///< itself: other formats are unpacked before they are read
  bool has_header = true;       ///< and so takes no options of raw files

  /// Whether a file's first bytes, decompressed, are those of the format.
  bool (*begins)(std::string_view head) = nullptr;
  /// Whether a file's name, or one beside it, says that it is of the format, and its first bytes do
  /// not say otherwise. `is_raw`: the options say what raw voxels it has.
  bool (*is_named)(const FileHead& head, bool is_raw) = nullptr;
  /// Whether the first bytes may be those of the format, which has no signature.
  bool (*resembles)(const FileHead& head) = nullptr;
  /// Errors: those of open_volume.
  Result<OpenVolume> (*open)(const FileHead& head, const ImportOptions& options) = nullptr;
};

/// The format of a file; null if no reader takes it. First bytes come before names. `is_raw`: the
/// options say what raw voxels it has.
const Format* format_of(const FileHead& head, bool is_raw);

/// "NRRD, MetaImage, … or legacy VTK".
std::string titles_of_formats();

}  // namespace isosplat::import
