#pragma once

#include <memory>
#include <string>
#include <vector>

#include "shared/import/axes/array_axes.h"
#include "shared/import/hdf5/volumes.h"

namespace isosplat::import {

/// The description by the first convention that the file follows. Errors: malformed_volume,
/// unsupported_format, those of reading attributes and positions.
Result<ArrayDescription> describe_hdf5(const std::shared_ptr<Hdf5File>& file,
                                       const Hdf5Volume& volume);

/// Sets the times of an axis of time from an array of them, unless it has another size or cannot be
/// decoded: the volume can be shown without times. Errors: io_error. `unit`:
/// also as CF writes it, "hours since 1900-01-01".
Result<void> read_hdf5_times(const std::shared_ptr<Hdf5File>& file, const Hdf5Object& object,
                             std::string unit, ArrayAxis& axis);

// The conventions. Each takes a description whose axes have their sizes, and returns whether the
// array follows the convention.
Result<bool> describe_imaris(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             ArrayDescription& description);
Result<bool> describe_big_data_viewer(const std::shared_ptr<Hdf5File>& file,
                                      const Hdf5Volume& volume, ArrayDescription& description);
Result<bool> describe_vtk_hdf(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              ArrayDescription& description);
Result<bool> describe_itk(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          ArrayDescription& description);
Result<bool> describe_chimera(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              ArrayDescription& description);
Result<bool> describe_emd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          ArrayDescription& description);
Result<bool> describe_matlab(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                             ArrayDescription& description);
Result<bool> describe_open_pmd(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                               ArrayDescription& description);
Result<bool> describe_by_attributes(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                                    ArrayDescription& description);

}  // namespace isosplat::import
