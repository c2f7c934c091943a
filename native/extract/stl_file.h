#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"

namespace isosplat {

/// A binary STL file: triangles without shared vertices, in single precision. It appears under its
/// name with publish(). Keeps the positions of all vertices in memory, 12 bytes each, since later
/// parts of a mesh refer to them.
class StlFile : public MeshFile {
 public:
  /// `comment`: at most 80 bytes are kept. Errors: those of OutputFile.
  static Result<StlFile> create(const std::filesystem::path& path, const VolumeGrid&,
                                std::string_view comment);

  /// Errors: io_error, invalid_argument (more than 2³² − 1 triangles).
  Result<void> append(const MeshPart& part) override;

  /// Completes the header, and gives the file its name. Errors: io_error.
  Result<void> publish() override;

  uint64_t bytes() const override { return end_; }

 private:
  StlFile(OutputFile file, std::string_view comment) : file_(std::move(file)), comment_(comment) {}

  OutputFile file_;
  std::string comment_;
  std::vector<Vec3f> positions_;
  uint64_t triangles_ = 0;
  uint64_t end_ = 84;  // after the header
  std::vector<std::byte> buffer_;
};

}  // namespace isosplat
