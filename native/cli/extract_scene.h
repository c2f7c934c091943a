#pragma once

#include "native/cli/extract_options.h"

namespace isosplat::cli {

/// Extracts the surfaces of a scene's layers, into one file if its format has objects, and into a
/// file for each surface otherwise. Returns the exit code.
int extract_scene(const ExtractCall& call);

}  // namespace isosplat::cli
