#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/grid/volume_source.h"

namespace isosplat::import {

/// The values from `low` to `high` (usually equal) that mean "no value" according to a file's
/// header. In DICOM, padding is often the value of air. For such unreliable headers, voxels become
/// absent only if these values are far from all others, and the others are not labels.
struct FillValue {
  double low = 0, high = 0;
  bool is_certain = true;
};

/// An open volume, and notes about how it was read. Each note is one sentence about an assumption,
/// an ignored part or a filled part, with the option that changes it where there is one. Notes are
/// shown to the user and kept in the store.
struct OpenVolume {
  std::unique_ptr<VolumeSource> source;
  std::vector<std::string> notes = {};
  /// The fill value of the file's header. Set by the readers of formats; open_volume applies it.
  std::optional<FillValue> fill_value = std::nullopt;
};

}  // namespace isosplat::import
