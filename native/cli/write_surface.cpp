#include "native/cli/write_surface.h"

#include "native/extract/mesh_components.h"
#include "native/extract/simplify_mesh.h"

namespace isosplat::cli {
namespace {

/// The whole mesh, not closed.
Result<MeshPart> extract_whole(const StoreFile& store, double isovalue,
                               const ExtractOptions& options) {
  MeshPart mesh;
  const auto extracted = extract_mesh(store, isovalue, options, [&](const MeshPart& part) {
    append_part(mesh, part);
    return Result<void>{};
  });
  if (!extracted) return tl::unexpected(extracted.error());
  return mesh;
}

/// The whole mesh, closed. If that is not required, a surface with holes stays open.
Result<MeshPart> extract_closed(const StoreFile& store, double isovalue,
                                const ExtractOptions& options, const SolidRequest& solid,
                                WrittenMesh& written) {
  auto mesh = extract_solid(store, isovalue, options, solid.cuts);
  const bool has_holes =
      !mesh && mesh.error().status == Status::invalid_argument && store.info().mapping.has_missing;
  if (!has_holes || solid.is_required) return mesh;
  written.is_left_open = true;
  return extract_whole(store, isovalue, options);
}

/// Changes a mesh, and writes it in one part.
Result<void> write_changed(MeshPart mesh, const MeshChanges& changes, MeshFile& file,
                           WrittenMesh& written) {
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
                                const std::optional<SolidRequest>& solid, MeshFile& file) {
  WrittenMesh written;
  if (solid || changes.any()) {
    auto mesh = solid ? extract_closed(store, isovalue, options, *solid, written)
                      : extract_whole(store, isovalue, options);
    if (!mesh) return tl::unexpected(mesh.error());
    auto done = write_changed(std::move(*mesh), changes, file, written);
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
  return extract_points(store, isovalue, projection, options, [&](const PointsWithFields& batch) {
    return file.append({batch, {}});
  });
}

}  // namespace isosplat::cli
