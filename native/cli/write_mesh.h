#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "native/extract/mesh_file.h"

namespace isosplat::cli {

/// Changes of a mesh before it is written. With any of them, the whole mesh is in memory.
struct MeshChanges {
  std::optional<size_t> components;      ///< number of largest components to keep
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

/// Extracts an isosurface into a file, in the format of its extension. comment: a line for the
/// file's header. Errors: those of mesh_format, extract_mesh, simplify_mesh and MeshFile.
Result<WrittenMesh> write_mesh(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const MeshChanges& changes,
                               const std::filesystem::path& path, const std::string& comment);

}  // namespace isosplat::cli
