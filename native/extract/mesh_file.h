#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "native/extract/extract_mesh.h"
#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A file to which parts of a mesh are written. It appears under its name with publish().
class MeshFile {
 public:
  virtual ~MeshFile() = default;

  /// Parts are those of extract_mesh, in its order. Errors: io_error, and invalid_argument if the
  /// format cannot hold this number of vertices or triangles.
  virtual Result<void> append(const MeshPart& part) = 0;

  /// The next parts are those of the next object of the description, and number their vertices from
  /// 0. Only for formats with has_objects. Errors: io_error.
  virtual Result<void> next_object() {
    return fail(Status::invalid_argument, "this format holds a single surface");
  }

  /// Completes the file, and renames it to its final name. Errors: io_error.
  virtual Result<void> publish() = 0;

  /// Bytes written so far.
  virtual uint64_t bytes() const = 0;

 protected:
  MeshFile() = default;
  MeshFile(MeshFile&&) = default;
  MeshFile& operator=(MeshFile&&) = default;
};

/// The parts of a surface that a file contains.
enum class SurfaceContent { points, triangles };

/// A surface that is written to a file.
struct SurfaceDescription {
  const VolumeGrid& grid;
  double isovalue;
  std::string_view comment;  ///< one line for the file's header
  SurfaceContent content = SurfaceContent::triangles;
  /// The surfaces of a file with has_objects, in order; empty: one without a name.
  std::span<const MeshObject> objects = {};
  /// Fields whose values all parts have, in this order. Only for formats with has_fields.
  std::span<const FieldColumn> fields = {};
};

/// A format of meshes, of points, or of both.
struct MeshFormat {
  std::string_view extension;  ///< lower case, with the dot
  std::string_view
      beginning;          ///< the first bytes of all files of this format that the program writes
  std::string_view name;  ///< for messages: "a PLY file"
  bool has_points, has_triangles;
  bool has_objects;  ///< several surfaces of triangles, with names
  bool is_solid;     ///< for printing: surfaces are closed unless the user wants them open
  bool has_fields;   ///< values of fields at points and vertices

  /// Creates a file. Errors: those of OutputFile.
  Result<std::unique_ptr<MeshFile>> (*create)(const std::filesystem::path& path,
                                              const SurfaceDescription& surface);

  bool has(SurfaceContent content) const {
    return content == SurfaceContent::points ? has_points : has_triangles;
  }
};

/// The format of a path's extension, in upper or lower case. Errors: invalid_argument if no format
/// has this extension, or if the format cannot store the content.
Result<const MeshFormat*> mesh_format(const std::filesystem::path& path, SurfaceContent content);

/// The extensions of all formats of this content: ".ply, .stl, …".
std::string mesh_extensions(SurfaceContent content);

/// Checks that a format can hold values of fields. Errors: invalid_argument, with the extensions of
/// those that can.
Result<void> check_holds_fields(const std::filesystem::path& path, const MeshFormat& format,
                                SurfaceContent content);

}  // namespace isosplat
