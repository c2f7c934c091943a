#pragma once

#include "native/cli/extract_options.h"

// Points on an isosurface of an unstructured grid, without a store.
namespace isosplat::cli {

/// Writes one point for each active cell of a file that is GridKind::unstructured (point_of_cell),
/// with its normal, the size of the cell, and the values of other arrays (--field). Prints the
/// result, or an error. Returns the exit code. Errors: those of open_vtk_mesh and the file;
/// invalid_argument for options that need a store.
int extract_cells(const ExtractCall& call);

}  // namespace isosplat::cli
