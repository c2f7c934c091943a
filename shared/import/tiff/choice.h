#pragma once

#include <array>
#include <vector>

#include "shared/import/tiff/series.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// The volume to read: a series, the axis of its slices, and an index on each of the other axes.
struct TiffVolume {
  TiffSeries series;
  TiffAxis slices = TiffAxis::z;
  std::array<uint64_t, 3> fixed{};  ///< by TiffAxis

  uint64_t size() const { return series.size(slices); }
};

/// Chooses one volume of a file by the options. Errors: invalid_argument if there are several and
/// no option chooses one, or none matches; unsupported_type if it has channels and none is chosen;
/// no_cells if the series have no slices.
Result<TiffVolume> choose_tiff_volume(const std::filesystem::path& path,
                                      std::vector<TiffSeries> series, const ImportOptions& options,
                                      std::vector<std::string>& notes);

/// All volumes of a file's series. Empty if there is only one.
std::vector<VolumeChoice> tiff_choices(const std::vector<TiffSeries>& series);

}  // namespace isosplat::import
