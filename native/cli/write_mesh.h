#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "native/extract/extract_mesh.h"

namespace isosplat::cli {

/// A kind of files: how all of them begin, and its name in messages.
struct FileKind {
  std::string_view beginning, name;
};

/// The kind of mesh file that an extension (.ply, .stl or .obj, in any case) says. Errors:
/// invalid_argument.
Result<FileKind> kind_of_mesh(const std::filesystem::path& path);

/// The mesh file that was written.
struct WrittenMesh {
  MeshCounts counts;
  uint64_t bytes = 0;
};

/// Extracts an isosurface into a file of the kind that its extension says. comment: a line for the
/// file's header. Errors: those of kind_of_mesh, extract_mesh and OutputFile.
Result<WrittenMesh> write_mesh(const StoreFile& store, double isovalue,
                               const ExtractOptions& options, const std::filesystem::path& path,
                               const std::string& comment);

}  // namespace isosplat::cli
