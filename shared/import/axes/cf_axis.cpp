#include "shared/import/axes/cf_axis.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/text/header_text.h"

namespace isosplat::import {

void name_by_positions(ArrayAxis& axis, const ArrayAttributes& attributes) {
  const auto text = [&](const char* name) { return lower_case(attributes.text(name)); };
  const std::string own = text("axis"), standard = text("standard_name"), units = text("units");
  if (own.size() == 1 && own.find_first_of("xyzt") == 0) axis.letter = own[0];
  if (axis.letter == 0) axis.letter = axis_letter(standard);
  if (axis.letter == 0 && units.find(" since ") != units.npos) axis.letter = 't';
  axis.is_downwards = text("positive") == "down";
}

Result<void> place_by_positions(ArrayAxis& axis, const std::vector<double>& positions,
                                const ArrayAttributes& attributes,
                                const std::filesystem::path& file,
                                std::vector<std::string>& notes) {
  if (positions.size() != axis.size || axis.size < 2) return {};
  const double millimetres =
      axis_millimetres(attributes.text("units"), "the axis " + printable(axis.name), notes);
  if (place_axis(axis, positions, millimetres)) return {};
  return fail(Status::unsupported_format,
              fmt::format("{}: expected evenly spaced positions along the axis {}, found others: "
                          "resample the volume",
                          file.string(), printable(axis.name)));
}

void set_times(ArrayAxis& axis, std::vector<double> times, std::string unit) {
  if (times.size() != axis.size) return;
  unit.resize(std::min(unit.find(" since "), unit.size()));
  axis.times = TimeAxis::of(std::move(times), std::move(unit));
}

}  // namespace isosplat::import
