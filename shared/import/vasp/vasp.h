#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes of a file are those of a POSCAR or a file that begins with one: the
/// format has no signature.
bool is_vasp(std::string_view head);

/// Opens VASP's volumes: CHGCAR, PARCHG, LOCPOT, ELFCAR and AECCAR. Errors: those of open_volume.
Result<OpenVolume> open_vasp(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
