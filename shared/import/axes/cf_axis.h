#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/axes/array_attributes.h"
#include "shared/import/axes/array_axes.h"

namespace isosplat::import {

/// Identifies an axis by the attributes of its positions: axis, standard_name, units, positive (CF,
/// chapters 4 and 5).
void name_by_positions(ArrayAxis& axis, const ArrayAttributes& attributes);

/// Places a named axis by its positions, in the unit of the attribute units, with a note if it is
/// not known. Positions of another number than its elements place nothing. Errors:
/// unsupported_format if they are not evenly spaced. `file`: for messages.
Result<void> place_by_positions(ArrayAxis& axis, const std::vector<double>& positions,
                                const ArrayAttributes& attributes,
                                const std::filesystem::path& file, std::vector<std::string>& notes);

/// The times of an axis, in a unit as CF writes it, "hours since 1900-01-01". Other numbers of
/// times than elements set nothing.
void set_times(ArrayAxis& axis, std::vector<double> times, std::string unit);

}  // namespace isosplat::import
