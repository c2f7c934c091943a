#pragma once

#include <functional>
#include <vector>

#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// Reads the numbers of an array in order, in parts of some KiB: visit(number) for each of `count`
/// numbers, as double; integers beyond 2^53 are rounded. visit() returns false to end the reading.
/// Errors: those of open_vtk_xml_array; malformed_volume if the array has no known type.
Result<void> visit_vtk_xml_numbers(const VtkXmlFile& file, const VtkXmlArray& array, uint64_t count,
                                   const std::function<bool(double)>& visit);

/// The numbers of an array. The number of bytes in the file is checked before memory is allocated.
Result<std::vector<double>> read_vtk_xml_numbers(const VtkXmlFile& file, const VtkXmlArray& array,
                                                 uint64_t count);

}  // namespace isosplat::import
