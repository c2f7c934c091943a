#pragma once

#include "native/import/open_volume.h"

namespace isosplat {

/// Makes voxels that stand for "no value" not a number, so that no surface is drawn around them and
/// they take no part of the range of values. Which value that is, options say, or the file's header
/// (volume.fill_value), or it is found: a single value far outside the range of all others that
/// fills a share of a floating-point volume. Whatever was assumed is noted.
///
/// A volume of integers that has such a value is read as floating-point numbers, which hold all of
/// its integers. Errors: those of the source, where it is searched.
Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options);

}  // namespace isosplat
