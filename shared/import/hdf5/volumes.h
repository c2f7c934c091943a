#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "shared/import/hdf5/type.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// A numeric dataset of an HDF5 file, with several elements along at least three axes.
struct Hdf5Volume {
  std::string path;    ///< "/entry/data"
  std::string parent;  ///< path of its group: "/entry"
  Hdf5Object object;
  std::vector<uint64_t> sizes;  ///< along all axes, the slowest first
  Hdf5Type type;
};

/// All volumes of a file, in the order of the links of groups. A dataset with several paths is
/// listed once; coarser copies (Imaris, BigDataViewer, Chimera) are not listed. If no dataset has
/// exactly three axes with several elements, those with more are listed, since these may include
/// times or channels. Errors: those of read_hdf5_object.
Result<std::vector<Hdf5Volume>> hdf5_volumes(Hdf5File& file);

/// The object at a path: names that are separated by "/". Nothing if there is none. Errors: those
/// of read_hdf5_object.
Result<std::optional<Hdf5Object>> hdf5_object_at(Hdf5File& file, std::string_view path);

/// The dataset with the path options.dataset, or without this option the file's only volume. If
/// there are several: the default that the file names (NeXus), or the finest resolution of an image
/// pyramid (Imaris, BigDataViewer) at options.time_step and options.channel, which are then
/// cleared. Errors: invalid_argument with the list of volumes if one must be chosen; no_cells,
/// unsupported_type, unsupported_format.
Result<Hdf5Volume> choose_hdf5_volume(Hdf5File& file, ImportOptions& options);

/// A command that saves one volume of an array with too many axes.
std::string hdf5_advice(const std::filesystem::path& file, const Hdf5Volume& volume);

}  // namespace isosplat::import
