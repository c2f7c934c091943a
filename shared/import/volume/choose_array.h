#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// An array with numbers of the points or of the cells of one grid.
struct GridArray {
  std::string name;
  bool of_cells = false;
  size_t components = 1;    ///< numbers per point or cell
  bool is_readable = true;  ///< its type is supported, and it has numbers of every point or cell
};

/// A number of each point or cell.
struct GridNumber {
  size_t array = 0, component = 0;
};

/// Selects an array and a component of it. Channels are the components of all readable arrays of
/// the points, or of the cells if points have none, in order, at most kMaxOffered. Without a
/// channel in the options, `scalars` is read, the index of an array; a note names it if there are
/// others. Requires `scalars` or a readable array. Errors: those of choose_channel.
Result<GridNumber> choose_array(const std::filesystem::path& path,
                                const std::vector<GridArray>& arrays, std::optional<size_t> scalars,
                                const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace isosplat::import
