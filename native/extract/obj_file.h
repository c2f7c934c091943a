#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "native/extract/extract_mesh.h"
#include "native/files/output_file.h"

namespace isosplat {

/// A Wavefront OBJ file: a text of vertices, normals and triangles. Numbers have as many digits as
/// single precision needs, positions those of double precision. It appears under its name with
/// publish().
class ObjFile {
 public:
  /// `comment`: one line. Errors: those of OutputFile.
  static Result<ObjFile> create(const std::filesystem::path& path, std::string_view comment);

  /// Errors: io_error.
  Result<void> append(const MeshPart& part);

  /// Gives the file its name. Errors: io_error.
  Result<void> publish() { return file_.publish(); }

  uint64_t bytes() const { return end_; }

 private:
  explicit ObjFile(OutputFile file) : file_(std::move(file)) {}
  Result<void> write(const std::string& text);

  OutputFile file_;
  uint64_t end_ = 0;
};

}  // namespace isosplat
