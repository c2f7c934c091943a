#pragma once

#include "shared/core/grid/grid.h"
#include "shared/render/pick/surface_pick.h"
#include "shared/render/samples/chunk_store.h"

namespace isosplat::render {

/// Sets the field's value of a pick on a surface: the trilinear interpolation in the cell where the
/// surface was found, or, of categories, the value of the nearest corner. Reads samples back from
/// the GPU.
void pick_field(const ChunkStore& chunks, const ValueMapping& field, bool is_category,
                SurfacePick& pick);

}  // namespace isosplat::render
