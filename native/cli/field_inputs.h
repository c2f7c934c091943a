#pragma once

#include <span>
#include <string>
#include <vector>

#include "native/builder/store_with_fields.h"
#include "shared/import/open_volume.h"

namespace isosplat::cli {

/// The fields that texts such as "temperature=t.nrrd" name, for the store `target` of a volume on
/// this grid. "name=file.h5#/path" names a dataset of a file. Reads the headers of all files, and
/// prints a note where one places the field elsewhere than the volume. Of the import options, the
/// time step and the allowances apply to fields. Errors: invalid_argument, those of open_volume and
/// check_field_grid.
Result<std::vector<FieldInput>> field_inputs(std::span<const std::string> texts,
                                             const import::ImportOptions& import_options,
                                             const VolumeGrid& grid,
                                             const std::filesystem::path& target);

}  // namespace isosplat::cli
