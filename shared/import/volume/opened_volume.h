#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/grid/volume_source.h"

namespace isosplat::import {

/// Values from `low` to `high` (usually equal) that stand for "no value" according to a file's
/// header. If the header is not reliable (in DICOM, padding is often the value of air), they become
/// absent only if they lie apart from all other values, and those are not labels.
struct FillValue {
  double low = 0, high = 0;
  bool is_certain = true;
};

/// An open volume, and notes about how it was read. Each note is one sentence: what was assumed,
/// ignored or filled, and, if useful, which option changes it. Notes are shown to the user and kept
/// in the store.
struct OpenVolume {
  std::unique_ptr<VolumeSource> source;
  std::vector<std::string> notes = {};
  /// The fill value of the file's header. Set by the readers of formats; open_volume applies it.
  std::optional<FillValue> fill_value = std::nullopt;
};

}  // namespace isosplat::import
