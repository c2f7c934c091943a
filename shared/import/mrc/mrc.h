#pragma once

#include <string_view>

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a file begins as MRC. `by_name`: the file has a name of MRC files, so the text "MAP "
/// may be missing, as in files from before 2000.
bool is_mrc(std::string_view beginning, bool by_name);

/// Opens a file of MRC. Errors: those of open_volume.
Result<OpenVolume> open_mrc(const FileHead& head, const ImportOptions& options);

}  // namespace isosplat::import
