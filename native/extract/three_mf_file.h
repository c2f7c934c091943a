#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"

namespace isosplat {

/// A 3MF file (3D Manufacturing Format, core specification 1.3), for printing: a ZIP archive with a
/// model of vertices and triangles in millimetres, without normals. The text of the model is kept
/// in temporary files until publish() compresses it.
class ThreeMfFile : public MeshFile {
 public:
  /// The surface's comment becomes the model's description. Errors: those of OutputFile.
  static Result<ThreeMfFile> create(const std::filesystem::path& path,
                                    const SurfaceDescription& surface);

  /// Errors: io_error, invalid_argument (more than 2³¹ vertices or triangles, the most that the
  /// format allows).
  Result<void> append(const MeshPart& part) override;

  Result<void> publish() override;

  /// 0 until publish().
  uint64_t bytes() const override { return end_; }

 private:
  ThreeMfFile(OutputFile file, SpooledBytes vertices, SpooledBytes triangles,
              std::string_view comment)
      : file_(std::move(file)),
        vertices_(std::move(vertices)),
        triangles_(std::move(triangles)),
        comment_(comment) {}

  OutputFile file_;
  SpooledBytes vertices_, triangles_;
  std::string comment_;
  uint64_t vertex_count_ = 0, triangle_count_ = 0;
  uint64_t end_ = 0;
};

}  // namespace isosplat
