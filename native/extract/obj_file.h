#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"

namespace isosplat {

/// A Wavefront OBJ file: vertices, normals and triangles as text. Numbers have the digits that
/// single precision needs, positions those of double precision. It appears under its name with
/// publish().
class ObjFile : public MeshFile {
 public:
  /// Errors: those of OutputFile.
  static Result<ObjFile> create(const std::filesystem::path& path,
                                const SurfaceDescription& surface);

  /// Errors: io_error.
  Result<void> append(const MeshPart& part) override;

  /// Renames the file to its final name. Errors: io_error.
  Result<void> publish() override { return file_.publish(); }

  uint64_t bytes() const override { return end_; }

 private:
  explicit ObjFile(OutputFile file) : file_(std::move(file)) {}
  Result<void> write(const std::string& text);

  OutputFile file_;
  uint64_t end_ = 0;
};

}  // namespace isosplat
