#pragma once

#include <string_view>

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes, decompressed, can be a header of FreeSurfer's MGH format. The format
/// has no signature. `by_name`: the file's name says so, so that fewer fields are compared.
bool is_mgh(std::string_view head, bool by_name);

/// Opens a volume of FreeSurfer (.mgh, .mgz). Errors: those of open_volume.
Result<OpenVolume> open_mgh(const FileHead& head, const ImportOptions& options);

}  // namespace isosplat::import
