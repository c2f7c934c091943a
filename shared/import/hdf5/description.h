#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/grid/grid.h"
#include "shared/import/hdf5/volumes.h"
#include "shared/import/volume/time_axis.h"

namespace isosplat::import {

/// An axis of an array.
struct Hdf5Axis {
  std::string name;   ///< in the file; empty: it has none
  char letter = 0;    ///< x, y, z, t (time) or c (channel); 0: unknown
  uint64_t size = 0;  ///< elements that belong to the volume; others are padding
  std::optional<double>
      step;          ///< from an element to the next one, mm; negative if positions decrease
  double first = 0;  ///< position of the first element, mm
  bool is_downwards = false;  ///< its positions are depths
  TimeAxis times = {};        ///< of an axis of time, if the file states them
};

/// The meaning of an array, by the conventions of the program that wrote it.
struct Hdf5Description {
  std::vector<Hdf5Axis> axes;  ///< the slowest first
  std::array<Vec3d, 3> directions{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};  ///< of x, y, z
  Vec3d origin{0, 0, 0};     ///< mm, added to the positions of the axes
  bool is_unsigned = false;  ///< its signed integers stand for unsigned ones
  bool knows_axes = false;   ///< the convention defines the axes, so that no note is needed
  std::vector<std::string> notes;
};

/// The description by the first convention that the file follows. Errors: malformed_volume,
/// unsupported_format, those of reading attributes and positions.
Result<Hdf5Description> describe_hdf5(const std::shared_ptr<Hdf5File>& file,
                                      const Hdf5Volume& volume);

/// The letter of an axis with this name: "x", "nx", "pixel_x", "lon", "column", …; 0 if none.
/// `has_width`: another axis is named "width", so that "height" is y.
char hdf5_axis_letter(std::string_view name, bool has_width = false);

/// Sets step and first from the positions along an axis. False if they are not evenly spaced.
bool place_hdf5_axis(Hdf5Axis& axis, const std::vector<double>& positions, double millimetres);

/// Sets the times of an axis of time from an array of them, unless it has another size or cannot be
/// decoded: the volume can be shown without times. Errors: io_error. `unit`:
/// also as CF writes it, "hours since 1900-01-01".
Result<void> read_hdf5_times(const std::shared_ptr<Hdf5File>& file, const Hdf5Object& object,
                             std::string unit, Hdf5Axis& axis);

/// Millimetres per unit; 1 with a note for an unknown unit. `what`: the owner of the unit.
double hdf5_millimetres(std::string unit, const std::string& what, std::vector<std::string>& notes);

// The conventions. Each takes a description whose axes have their sizes, and returns whether the
// array follows the convention.
Result<bool> describe_imaris(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             Hdf5Description& description);
Result<bool> describe_big_data_viewer(const std::shared_ptr<Hdf5File>& file,
                                      const Hdf5Volume& volume, Hdf5Description& description);
Result<bool> describe_vtk_hdf(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              Hdf5Description& description);
Result<bool> describe_itk(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          Hdf5Description& description);
Result<bool> describe_chimera(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              Hdf5Description& description);
Result<bool> describe_emd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          Hdf5Description& description);
Result<bool> describe_matlab(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             Hdf5Description& description);
Result<bool> describe_open_pmd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                               Hdf5Description& description);
Result<bool> describe_by_attributes(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                                    Hdf5Description& description);

}  // namespace isosplat::import
