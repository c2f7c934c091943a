#pragma once

#include <filesystem>
#include <optional>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"
#include "shared/core/mesh_files/mesh_encoder.h"

namespace isosplat {

/// A file of an encoder's bytes. The bytes for its end are kept in a temporary file until the rest
/// is complete.
class EncodedFile : public MeshFile {
 public:
  /// Errors: those of OutputFile.
  static Result<EncodedFile> create(const std::filesystem::path& path,
                                    std::unique_ptr<MeshEncoder> encoder);

  /// Errors: io_error, and those of the encoder.
  Result<void> append(const MeshPart& part) override;
  Result<void> next_object() override;
  Result<void> publish() override;
  uint64_t bytes() const override { return end_; }

 private:
  EncodedFile(OutputFile file, std::filesystem::path folder, std::unique_ptr<MeshEncoder> encoder)
      : file_(std::move(file)),
        folder_(std::move(folder)),
        encoder_(std::move(encoder)),
        end_(encoder_->header_bytes()) {}

  OutputFile file_;
  std::filesystem::path folder_;
  std::unique_ptr<MeshEncoder> encoder_;
  std::optional<SpooledBytes> tail_;  ///< no value until there are bytes for it
  EncodedPart part_;
  uint64_t end_;
};

}  // namespace isosplat
