#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"

namespace isosplat {

/// A 3MF file (3D Manufacturing Format, core specification 1.3), for printing: a ZIP archive with a
/// model of vertices and triangles in millimetres, without normals. Objects have their names and
/// colours (basematerials, section 5.1); those without triangles are left out. The text of the
/// model is kept in temporary files until publish() compresses it.
class ThreeMfFile : public MeshFile {
 public:
  /// The surface's comment becomes the model's description. Errors: those of OutputFile.
  static Result<ThreeMfFile> create(const std::filesystem::path& path,
                                    const SurfaceDescription& surface);

  /// Errors: io_error, invalid_argument (more than 2³¹ vertices or triangles, the most that the
  /// format allows).
  Result<void> append(const MeshPart& part) override;

  Result<void> next_object() override;
  Result<void> publish() override;

  /// 0 until publish().
  uint64_t bytes() const override { return end_; }

 private:
  ThreeMfFile(OutputFile file, SpooledBytes model, SpooledBytes vertices, SpooledBytes triangles,
              const SurfaceDescription& surface)
      : file_(std::move(file)),
        model_(std::move(model)),
        vertices_(std::move(vertices)),
        triangles_(std::move(triangles)),
        comment_(surface.comment),
        objects_(surface.objects.begin(), surface.objects.end()) {}

  /// Moves the open object into the model.
  Result<void> close_object();
  std::string materials() const;

  OutputFile file_;
  SpooledBytes model_;                 ///< the objects that are complete
  SpooledBytes vertices_, triangles_;  ///< of the open object
  std::string comment_;
  std::vector<MeshObject> objects_;
  size_t open_ = 0;                                 ///< index of the open object
  std::vector<size_t> built_;                       ///< indices of the objects that have triangles
  uint64_t vertex_count_ = 0, triangle_count_ = 0;  ///< of the open object
  uint64_t end_ = 0;
};

}  // namespace isosplat
