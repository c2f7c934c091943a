#include "native/cli/write_surface.h"

#include "native/extract/mesh_components.h"
#include "native/extract/simplify_mesh.h"

namespace isosplat::cli {
namespace {

void append(MeshPart& all, const MeshPart& part) {
  const auto add = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  add(all.vertices.positions, part.vertices.positions);
  add(all.vertices.normals, part.vertices.normals);
  add(all.triangles, part.triangles);
}

/// Extracts the whole mesh, changes it, and writes it in one part.
Result<void> write_changed(const StoreFile& store, double isovalue, const ExtractOptions& options,
                           const MeshChanges& changes, MeshFile& file, WrittenMesh& written) {
  MeshPart mesh;
  const auto extracted = extract_mesh(store, isovalue, options, [&](const MeshPart& part) {
    append(mesh, part);
    return Result<void>{};
  });
  if (!extracted) return tl::unexpected(extracted.error());
  if (changes.components) {
    written.components_found = keep_largest_components(mesh, *changes.components);
  }
  if (changes.simplify_error) {
    const auto error = simplify_mesh(mesh, *changes.simplify_error);
    if (!error) return tl::unexpected(error.error());
    written.simplified_within = *error;
  }
  written.counts = {mesh.vertices.positions.size(), mesh.triangles.size()};
  return file.append(mesh);
}

}  // namespace

Result<WrittenMesh> append_mesh(const StoreFile& store, double isovalue,
                                const ExtractOptions& options, const MeshChanges& changes,
                                MeshFile& file) {
  WrittenMesh written;
  if (changes.any()) {
    auto done = write_changed(store, isovalue, options, changes, file, written);
    if (!done) return tl::unexpected(done.error());
    return written;
  }
  const auto counts = extract_mesh(store, isovalue, options,
                                   [&](const MeshPart& part) { return file.append(part); });
  if (!counts) return tl::unexpected(counts.error());
  written.counts = *counts;
  return written;
}

Result<uint64_t> append_points(const StoreFile& store, double isovalue,
                               const ProjectionOptions& projection, const ExtractOptions& options,
                               MeshFile& file) {
  return extract_points(store, isovalue, projection, options, [&](const PointArrays& batch) {
    return file.append({batch, {}});
  });
}

}  // namespace isosplat::cli
