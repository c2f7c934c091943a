#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/grid/grid.h"
#include "shared/import/volume/time_axis.h"

namespace isosplat::import {

/// An axis of an array.
struct ArrayAxis {
  std::string name;   ///< in the file; empty: it has none
  char letter = 0;    ///< x, y, z, t (time) or c (channel); 0: unknown
  uint64_t size = 0;  ///< elements that belong to the volume; others are padding
  /// From an element to the next one, mm; negative if positions decrease.
  std::optional<double> step = {};
  double first = 0;           ///< position of the first element, mm
  bool is_downwards = false;  ///< its positions are depths
  TimeAxis times = {};        ///< of an axis of time, if the file states them
};

/// The meaning of an array, by the conventions of the program that wrote it.
struct ArrayDescription {
  std::vector<ArrayAxis> axes;  ///< the slowest first
  std::array<Vec3d, 3> directions{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};  ///< of x, y, z
  Vec3d origin{0, 0, 0};     ///< mm, added to the positions of the axes
  bool is_unsigned = false;  ///< its signed integers stand for unsigned ones
  bool knows_axes = false;   ///< the convention defines the axes, so that no note is needed
  std::vector<std::string> notes;
};

/// The letter of an axis with this name: "x", "nx", "pixel_x", "lon", "column", …; 0 if none.
/// `has_width`: another axis is named "width", so that "height" is y.
char axis_letter(std::string_view name, bool has_width = false);

/// Sets step and first from the positions along an axis. False if they are not evenly spaced.
bool place_axis(ArrayAxis& axis, const std::vector<double>& positions, double millimetres);

/// Millimetres per unit; 1 with a note for an unknown unit. `what`: the owner of the unit.
double axis_millimetres(std::string unit, const std::string& what, std::vector<std::string>& notes);

}  // namespace isosplat::import
