#pragma once

#include <optional>

#include "native/extract/extract_solid.h"
#include "native/extract/mesh_file.h"

namespace isosplat::cli {

/// Changes of a mesh before it is written. With any of them, the whole mesh is in memory.
struct MeshChanges {
  std::optional<size_t> components;      ///< number of largest components to keep
  std::optional<double> simplify_error;  ///< see simplify_mesh

  bool any() const { return components || simplify_error; }
};

/// A surface that was written.
struct WrittenMesh {
  MeshCounts counts;
  std::optional<size_t> components_found;   ///< before some were dropped
  std::optional<double> simplified_within;  ///< the largest error of the simplification
  bool is_left_open = false;  ///< it should have been closed, but missing voxels leave holes
};

/// How a surface is closed.
struct SolidRequest {
  SolidCuts cuts = {};
  /// Whether holes that missing voxels leave are an error. Otherwise the surface is written open.
  bool is_required = true;
};

/// Extracts an isosurface as triangles into a file. solid: closes it. Errors: those of
/// extract_mesh, extract_solid, simplify_mesh and MeshFile.
Result<WrittenMesh> append_mesh(const StoreFile& store, double isovalue,
                                const ExtractOptions& options, const MeshChanges& changes,
                                const std::optional<SolidRequest>& solid, MeshFile& file);

/// Extracts an isosurface as points into a file. Returns their number. Errors: those of
/// extract_points and MeshFile.
Result<uint64_t> append_points(const StoreFile& store, double isovalue,
                               const ProjectionOptions& projection, const ExtractOptions& options,
                               MeshFile& file);

}  // namespace isosplat::cli
