#pragma once

#include <filesystem>
#include <string_view>

#include "native/files/output_file.h"
#include "shared/points/chunk_samples.h"

namespace isosplat {

/// A binary little-endian PLY file of points with normals, which MeshLab, CloudCompare, Open3D and
/// VTK read. It appears under its name with publish(). The number of points need not be known in
/// advance.
///
/// Positions have single precision if its error is at most 1/2000 of a voxel in the whole volume,
/// otherwise double precision: at UTM coordinates the error of single precision is half a metre.
/// Normals always have single precision.
class PlyFile {
 public:
  /// `grid`: of the volume that contains the points. `comment`: one line for the header. Errors:
  /// those of OutputFile.
  static Result<PlyFile> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment);

  /// Errors: io_error.
  Result<void> append(const PointArrays& points);

  /// Completes the header, and gives the file its name. Errors: io_error.
  Result<void> publish();

  uint64_t bytes() const { return end_; }

 private:
  PlyFile(OutputFile file, bool doubles, std::string comment)
      : file_(std::move(file)), doubles_(doubles), comment_(std::move(comment)) {}
  std::string header() const;

  OutputFile file_;
  bool doubles_;
  std::string comment_;
  uint64_t points_ = 0;
  uint64_t end_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace isosplat
