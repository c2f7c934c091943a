#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "shared/import/hdf5/file.h"

namespace isosplat::import {

/// The index of a dataset in an image pyramid. Imaris and BigDataViewer store one array for each
/// resolution, time and channel, and state these in its path.
struct Hdf5Place {
  uint64_t level = 0;  ///< 0: the finest
  uint64_t time = 0;
  uint64_t channel = 0;  ///< of BigDataViewer: a setup, such as a channel or an angle
  bool is_imaris = false;
};

/// "/DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data" (Imaris) or "/t00000/s00/0/cells"
/// (BigDataViewer); nothing for other paths.
std::optional<Hdf5Place> hdf5_place(std::string_view path);

/// The name of a channel of Imaris or a setup of BigDataViewer, such as " (GFP)"; empty if it has
/// none.
std::string hdf5_channel_name(Hdf5File& file, uint64_t channel, bool is_imaris);

}  // namespace isosplat::import
