#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "native/extract/mesh_file.h"

namespace isosplat::cli {

/// What is done with a mesh before it is written. If anything is, the whole mesh is in memory.
struct MeshChanges {
  std::optional<size_t> components;      ///< keep so many of the largest ones
  std::optional<double> simplify_error;  ///< see simplify_mesh

  bool any() const { return components || simplify_error; }
};

/// The mesh file that was written.
struct WrittenMesh {
  MeshCounts counts;
  uint64_t bytes = 0;
  std::optional<size_t> components_found;   ///< before some were dropped
  std::optional<double> simplified_within;  ///< the largest error of the simplification
};

/// Extracts an isosurface into a file of the format that its extension says. comment: a line for
/// the file's header. Errors: those of mesh_format, extract_mesh, simplify_mesh and MeshFile.
Result<WrittenMesh> write_mesh(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const MeshChanges& changes,
                               const std::filesystem::path& path, const std::string& comment);

}  // namespace isosplat::cli
