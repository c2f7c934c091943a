#pragma once

#include <string>
#include <vector>

#include "shared/import/volume/choose_array.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// The array and component that the options select, of those of the first piece: the array that
/// `Scalars` names, else the first one with one component, of the points, else of the cells;
/// --dataset chooses an array by its name, --channel any component of an array. Errors: those of
/// choose_array; invalid_argument if no array has the name, with the names; unsupported_format for
/// types that are not read; malformed_volume without arrays.
Result<GridNumber> choose_vtk_xml_array(const VtkXmlFile& file,
                                        const std::vector<VtkXmlArray>& found,
                                        const ImportOptions& options,
                                        std::vector<std::string>& notes);

/// Whether an array has flags of hidden or repeated points and cells, not values.
bool are_vtk_ghost_flags(const VtkXmlArray& array);

}  // namespace isosplat::import
