#pragma once

#include <filesystem>
#include <string_view>

#include "native/files/output_file.h"
#include "shared/points/chunk_samples.h"

namespace isosplat {

/// A binary little-endian PLY file of points with normals, as MeshLab, CloudCompare, Open3D and VTK
/// open it. It appears under its name only with publish(); the number of points need not be known
/// before.
///
/// Positions are single precision where that is within 1/2000 of a voxel anywhere in the volume,
/// and doubles otherwise: at UTM coordinates single precision is half a metre off. Normals are
/// single precision always.
class PlyFile {
 public:
  /// `grid`: where the points are to lie. `comment`: one line for people, in the header. Errors:
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
