#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"

namespace isosplat {

/// A binary glTF 2.0 file: interleaved positions and normals in single precision, and triangles,
/// which are kept in a temporary file until the vertices are complete.
///
/// glTF uses metres, y up and z towards the viewer. The volume is assumed to use millimetres, in
/// LPS orientation (z up, y to the back). A node of the file converts them. Positions are relative
/// to the middle of the volume if single precision would otherwise not do (needs_doubles); a second
/// node holds the offset.
class GlbFile : public MeshFile {
 public:
  /// `comment`: for asset.generator. Errors: those of OutputFile.
  static Result<GlbFile> create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment);

  /// Errors: io_error, invalid_argument (the file would exceed 4 GiB, the most that GLB holds).
  Result<void> append(const MeshPart& part) override;

  Result<void> publish() override;

  uint64_t bytes() const override { return end_; }

 private:
  GlbFile(OutputFile file, SpooledBytes triangles, Vec3d offset, std::string_view comment)
      : file_(std::move(file)),
        triangles_(std::move(triangles)),
        offset_(offset),
        comment_(comment) {}
  std::string scene() const;

  OutputFile file_;
  SpooledBytes triangles_;
  Vec3d offset_;  ///< of the positions in the file
  std::string comment_;
  uint64_t vertices_ = 0;
  uint64_t end_;
  Vec3f low_{}, high_{};  ///< the box around the positions in the file
  std::vector<std::byte> buffer_;
};

}  // namespace isosplat
