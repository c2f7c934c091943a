#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"
#include "shared/points/chunk_samples.h"

namespace isosplat {

/// A binary little-endian PLY file of points with normals, and optionally of triangles, which
/// MeshLab, CloudCompare, Open3D and VTK read. It appears under its name with publish(). The number
/// of points and triangles need not be known in advance: triangles are kept in a temporary file.
///
/// Positions have single precision if its error is at most 1/2000 of a voxel in the whole volume,
/// otherwise double precision: at UTM coordinates the error of single precision is half a metre.
/// Normals always have single precision.
class PlyFile {
 public:
  enum class Content { points, triangles };

  /// `grid`: of the volume that contains the points. `comment`: one line for the header. Errors:
  /// those of OutputFile.
  static Result<PlyFile> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment, Content content = Content::points);

  /// Errors: io_error.
  Result<void> append(const PointArrays& points);

  /// Requires Content::triangles. Indices are those of points in the order of append(). Errors:
  /// io_error.
  Result<void> append(std::span<const std::array<uint32_t, 3>> triangles);

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
  std::optional<SpooledBytes> spooled_;  // the triangles, if there are to be any
  uint64_t points_ = 0, triangles_ = 0;
  uint64_t end_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace isosplat
