#include "native/cli/write_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "native/extract/obj_file.h"
#include "native/extract/ply_file.h"
#include "native/extract/stl_file.h"

namespace isosplat::cli {
namespace {

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Writes all parts to a file, and gives it its name.
template <class File>
Result<WrittenMesh> write_parts(const StoreFile& store, double isovalue,
                                const ExtractOptions& options, Result<File> file) {
  if (!file) return tl::unexpected(file.error());
  const auto counts = extract_mesh(store, isovalue, options,
                                   [&](const MeshPart& part) { return file->append(part); });
  if (!counts) return tl::unexpected(counts.error());
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return WrittenMesh{*counts, file->bytes()};
}

/// A PLY file as a file of mesh parts.
struct PlyMesh {
  PlyFile file;

  static Result<PlyMesh> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                const std::string& comment) {
    auto ply = PlyFile::create(path, grid, comment, PlyFile::Content::triangles);
    if (!ply) return tl::unexpected(ply.error());
    return PlyMesh{std::move(*ply)};
  }
  Result<void> append(const MeshPart& part) {
    if (auto points = file.append(part.vertices); !points) return points;
    return file.append(part.triangles);
  }
  Result<void> publish() { return file.publish(); }
  uint64_t bytes() const { return file.bytes(); }
};

}  // namespace

Result<FileKind> kind_of_mesh(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension == ".ply") return FileKind{"ply\n", "a PLY file"};
  if (extension == ".stl") return FileKind{"isosurface", "an STL file of this program"};
  if (extension == ".obj") return FileKind{"# isosurface", "an OBJ file of this program"};
  return fail(
      Status::invalid_argument,
      fmt::format("{}: expected a mesh file's extension (.ply, .stl or .obj), found \"{}\": "
                  "choose one of them",
                  path.string(), path.extension().string()));
}

Result<WrittenMesh> write_mesh(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const std::filesystem::path& path,
                               const std::string& comment) {
  if (auto kind = kind_of_mesh(path); !kind) return tl::unexpected(kind.error());
  const std::string extension = extension_of(path);
  if (extension == ".stl") {
    return write_parts(store, isovalue, options, StlFile::create(path, comment));
  }
  if (extension == ".obj") {
    return write_parts(store, isovalue, options, ObjFile::create(path, comment));
  }
  return write_parts(store, isovalue, options, PlyMesh::create(path, store.info().grid, comment));
}

}  // namespace isosplat::cli
