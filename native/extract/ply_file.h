#pragma once

#include <filesystem>
#include <string_view>

#include "native/files/output_file.h"
#include "shared/points/chunk_samples.h"

namespace isosplat {

/// A binary little-endian PLY file of points with normals, as MeshLab and CloudCompare open it. It
/// appears under its name only with publish(); the number of points need not be known before.
class PlyFile {
 public:
  /// `comment`: one line for people, in the header. Errors: those of OutputFile.
  static Result<PlyFile> create(const std::filesystem::path& path, std::string_view comment);

  /// Errors: io_error.
  Result<void> append(const PointArrays& points);

  /// Completes the header, and gives the file its name. Errors: io_error.
  Result<void> publish();

  uint64_t bytes() const { return end_; }

 private:
  PlyFile(OutputFile file, std::string comment)
      : file_(std::move(file)), comment_(std::move(comment)) {}
  std::string header() const;

  OutputFile file_;
  std::string comment_;
  uint64_t points_ = 0;
  uint64_t end_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace isosplat
