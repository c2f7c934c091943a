#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"

namespace isosplat {

/// A Wavefront OBJ file: vertices, normals and triangles as text. Numbers have the digits that
/// single precision needs, positions those of double precision. Objects have their names, and no
/// colours, which OBJ keeps in a second file. It appears under its name with publish().
class ObjFile : public MeshFile {
 public:
  /// Errors: those of OutputFile.
  static Result<ObjFile> create(const std::filesystem::path& path,
                                const SurfaceDescription& surface);

  /// Errors: io_error.
  Result<void> append(const MeshPart& part) override;

  Result<void> next_object() override;

  /// Renames the file to its final name. Errors: io_error.
  Result<void> publish() override { return file_.publish(); }

  uint64_t bytes() const override { return end_; }

 private:
  ObjFile(OutputFile file, std::span<const MeshObject> objects)
      : file_(std::move(file)), objects_(objects.begin(), objects.end()) {}
  Result<void> write_name();
  Result<void> write(const std::string& text);

  OutputFile file_;
  uint64_t end_ = 0;
  std::vector<MeshObject> objects_;
  size_t open_ = 0;        ///< index of the object whose parts are appended
  uint64_t before_ = 0;    ///< number of the vertices of earlier objects
  uint64_t vertices_ = 0;  ///< of all objects
};

}  // namespace isosplat
