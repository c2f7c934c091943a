#pragma once

#include "native/cli/field_file.h"
#include "shared/core/categories/categories.h"
#include "shared/core/grid/volume_source.h"

namespace isosplat::cli {

/// The values that a volume of labels has, ascending, with the names and colours of the file's own
/// table or `file.table`. Values without a colour there have that of label_colour(), 0 is grey.
/// Reads the volume once, slice by slice. Errors: those of the volume and of read_label_table;
/// malformed_volume for values that are not integers up to ±kMaxCategory, for more than
/// kMaxCategories, for values that are more than kMaxCategorySpan apart, and for none.
Result<std::vector<Category>> field_categories(const FieldFile& file, VolumeSource& volume);

}  // namespace isosplat::cli
