#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/import/open_volume.h"

// The volumes of a build of several stores: steps of time, and channels.
namespace isosplat::cli {

/// A volume of a scene: a file, or one of the volumes of a file.
struct SceneInput {
  std::filesystem::path file;
  import::ImportOptions options;  ///< which of its volumes
  size_t layer = 0, step = 0;     ///< from 0
};

struct SceneInputs {
  std::vector<SceneInput> volumes;                             ///< by layer, then by step
  std::vector<std::string> layers;                             ///< the name of each; empty: none
  std::vector<std::optional<std::array<float, 3>>> colours{};  ///< sRGB, of the first layers
  std::vector<double> times;         ///< of each step; a single one: no time
  std::string time_unit{};           ///< as the file states it; may be empty
  std::vector<std::string> notes{};  ///< for the user
};

/// The steps of a series in files, in natural order: step_2.nrrd before step_10.nrrd. Their times
/// are the numbers in which the names differ, or else their indices.
SceneInputs files_as_steps(std::vector<std::filesystem::path> files,
                           const import::ImportOptions& options);

/// The steps in a list: a text file with a line for each step, which is its time, a blank and its
/// path, relative to the list. Empty lines, and lines that begin with #, are left out. Errors:
/// io_error, malformed_volume (the line, what was expected and found).
Result<SceneInputs> listed_steps(const std::filesystem::path& list,
                                 const import::ImportOptions& options);

/// The volumes of a file: a layer for each channel, and a step for each time step. Errors: those of
/// open_volume, if the file has volumes of another kind.
Result<SceneInputs> volumes_of_file(const std::filesystem::path& file,
                                    const import::ImportOptions& options);

}  // namespace isosplat::cli
