#pragma once

#include <cstdint>
#include <filesystem>

#include "shared/system/scene_file/scene_file.h"

namespace isosplat {

/// Puts a scene and its stores into a bundle. Returns its size in bytes. Errors: those of
/// SceneFile and OutputFile; malformed_header if a store is not below the scene's folder. The
/// output must not be one of the inputs.
Result<uint64_t> write_bundle(const SceneFile& scene, const std::filesystem::path& output);

/// Writes the scene of a bundle (as scene.json) and its stores into a folder, byte for byte as they
/// were. Nothing is replaced unless `force`. Returns the number of files. Errors: io_error,
/// invalid_argument.
Result<size_t> unbundle(const SceneFile& bundle, const std::filesystem::path& folder, bool force);

}  // namespace isosplat
