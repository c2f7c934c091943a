#pragma once

#include <filesystem>
#include <string>

#include "native/builder/builder.h"
#include "native/cli/field_inputs.h"
#include "native/cli/scene_inputs.h"

namespace isosplat::cli {

struct SceneBuildOptions {
  BuildOptions build;
  std::string key;        ///< all options that determine the bytes of stores, as text
  std::string name;       ///< of the scene
  std::string time_unit;  ///< empty: that of the file
  bool force = false;
  std::vector<std::vector<FieldFile>> fields = {};  ///< of the stores of each step
};

/// The result of a build of several stores.
struct SceneReport {
  size_t layers = 0, steps = 0;
  size_t kept = 0;  ///< stores that an earlier, interrupted build has completed
  uint64_t bytes = 0;
  double seconds = 0;
};

/// Builds the stores of several volumes and their scene: a bundle or a folder (SceneOutput). The
/// steps of a layer have the same quantized values, which follow from all of them, so that an
/// isovalue selects the same voxels throughout. Prints notes and progress on stderr. Errors: those
/// of open_volume, build_store_file, place_fields, choose_quantization and SceneOutput;
/// invalid_argument if the output is one of the inputs.
Result<SceneReport> build_scene(const SceneInputs& inputs, const std::filesystem::path& output,
                                const SceneBuildOptions& options);

}  // namespace isosplat::cli
