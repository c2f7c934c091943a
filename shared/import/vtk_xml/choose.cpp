#include "shared/import/vtk_xml/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "shared/import/volume/refusals.h"

namespace isosplat::import {

bool are_vtk_ghost_flags(const VtkXmlArray& array) {
  return array.name == "vtkGhostType" || array.name == "vtkGhostLevels";
}

Result<GridNumber> choose_vtk_xml_array(const VtkXmlFile& file,
                                        const std::vector<VtkXmlArray>& found,
                                        const ImportOptions& options,
                                        std::vector<std::string>& notes) {
  std::vector<GridArray> arrays;
  std::string names;
  for (const VtkXmlArray& array : found) {
    const bool is_readable = array.type && !are_vtk_ghost_flags(array);
    const bool is_wanted = options.dataset.empty() || array.name == options.dataset;
    arrays.push_back({array.name, array.of_cells, static_cast<size_t>(array.components),
                      is_readable && is_wanted});
    if (is_readable && names.size() < 1000) {
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", array.name);
    }
  }
  const bool has_any = std::any_of(arrays.begin(), arrays.end(),
                                   [](const GridArray& array) { return array.is_readable; });
  if (!has_any && !options.dataset.empty() && !names.empty()) {
    return fail(Status::invalid_argument,
                fmt::format("{}: --dataset: expected one of {}, found '{}'", file.path.string(),
                            names, options.dataset));
  }
  if (!has_any) {
    for (const VtkXmlArray& array : found) {
      if (!array.type) return unknown_type(file.path, array.type_name);
    }
    return malformed_vtk_xml(file.path, "expected PointData or CellData, found none");
  }
  std::optional<size_t> scalars;
  for (const bool of_cells : {false, true}) {
    const std::string& named = of_cells ? file.cell_scalars : file.point_scalars;
    for (const bool needs_name : {true, false}) {
      for (size_t i = 0; i < arrays.size() && !scalars; ++i) {
        const GridArray& array = arrays[i];
        const bool is_named = !needs_name || (!named.empty() && array.name == named);
        if (array.of_cells == of_cells && array.is_readable && array.components == 1 && is_named) {
          scalars = i;
        }
      }
    }
  }
  return choose_array(file.path, arrays, scalars, options, notes);
}

}  // namespace isosplat::import
