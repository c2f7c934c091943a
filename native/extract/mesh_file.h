#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "native/extract/extract_mesh.h"

namespace isosplat {

/// A file that parts of a mesh are written to. It appears under its name with publish().
class MeshFile {
 public:
  virtual ~MeshFile() = default;

  /// Parts are those of extract_mesh, in its order. Errors: io_error, and invalid_argument if the
  /// format cannot hold this number of vertices or triangles.
  virtual Result<void> append(const MeshPart& part) = 0;

  /// Completes the file, and gives it its name. Errors: io_error.
  virtual Result<void> publish() = 0;

  /// Bytes written so far.
  virtual uint64_t bytes() const = 0;

 protected:
  MeshFile() = default;
  MeshFile(MeshFile&&) = default;
  MeshFile& operator=(MeshFile&&) = default;
};

/// What a file has of a surface.
enum class SurfaceContent { points, triangles };

/// A surface whose parts a file gets.
struct SurfaceDescription {
  const VolumeGrid& grid;
  double isovalue;
  std::string_view comment;  ///< one line for the file's header
  SurfaceContent content = SurfaceContent::triangles;
};

/// A format of meshes, of points, or of both.
struct MeshFormat {
  std::string_view extension;  ///< lower case, with the dot
  std::string_view
      beginning;          ///< the first bytes of all files of this format that the program writes
  std::string_view name;  ///< for messages: "a PLY file"
  bool has_points, has_triangles;

  /// Creates a file. Errors: those of OutputFile.
  Result<std::unique_ptr<MeshFile>> (*create)(const std::filesystem::path& path,
                                              const SurfaceDescription& surface);

  bool has(SurfaceContent content) const {
    return content == SurfaceContent::points ? has_points : has_triangles;
  }
};

/// The format that a path's extension says, in upper or lower case. Errors: invalid_argument if no
/// format has it, or if that format cannot hold the content.
Result<const MeshFormat*> mesh_format(const std::filesystem::path& path, SurfaceContent content);

/// The extensions of all formats of this content: ".ply, .stl, …".
std::string mesh_extensions(SurfaceContent content);

}  // namespace isosplat
