#pragma once

#include <filesystem>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat::cli {

/// A temporary folder for a file that will be uploaded. It is locked, and removed at the end unless
/// keep() was called. If the program is killed, the next create() in the same parent folder removes
/// it.
class UploadFolder {
 public:
  /// Removes the folders of this user that programs have left, then makes one. parent: empty: the
  /// system's folder of temporary files. Errors: io_error.
  static Result<UploadFolder> create(std::filesystem::path parent);

  UploadFolder() = default;  ///< no folder
  UploadFolder(UploadFolder&& other) noexcept;
  UploadFolder& operator=(UploadFolder&& other) noexcept;
  ~UploadFolder();

  const std::filesystem::path& path() const { return path_; }

  /// Gives the folder a name that create() never removes. Returns its path.
  std::filesystem::path keep();

 private:
  std::filesystem::path path_;  // empty: nothing is removed at the end
  PosixFile lock_;              // the opened folder
};

}  // namespace isosplat::cli
