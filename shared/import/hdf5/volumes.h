#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "shared/import/hdf5/type.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// A dataset of an HDF5 file with numbers, of which at least three axes have several elements.
struct Hdf5Volume {
  std::string path;    ///< "/entry/data"
  std::string parent;  ///< of the group that it is in: "/entry"
  Hdf5Object object;
  std::vector<uint64_t> sizes;  ///< along all axes, the slowest first
  Hdf5Type type;
};

/// All volumes of a file, in the order of the links of groups. A dataset with several paths is
/// listed once, coarser copies (Imaris, BigDataViewer, Chimera) not at all. If no dataset has three
/// axes with several elements, those with more are listed: times or channels may be among them.
/// Errors: those of read_hdf5_object.
Result<std::vector<Hdf5Volume>> hdf5_volumes(Hdf5File& file);

/// The object at a path: names that are separated by "/". Nothing if there is none. Errors: those
/// of read_hdf5_object.
Result<std::optional<Hdf5Object>> hdf5_object_at(Hdf5File& file, std::string_view path);

/// The dataset with the path options.dataset, or without one the file's only volume; of several,
/// the one that the file names as its default (NeXus), or the finest resolution of an image pyramid
/// (Imaris, BigDataViewer) at options.time_step and options.channel, which are taken. Errors:
/// invalid_argument if one has to be chosen, with their list; no_cells, unsupported_type,
/// unsupported_format.
Result<Hdf5Volume> choose_hdf5_volume(Hdf5File& file, ImportOptions& options);

/// How to save one volume of an array with too many axes: a command.
std::string hdf5_advice(const std::filesystem::path& file, const Hdf5Volume& volume);

}  // namespace isosplat::import
