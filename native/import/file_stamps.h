#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "native/import/volume_source.h"
#include "shared/posix_file/posix_file.h"

namespace isosplat {

/// What files were when they were looked at: size, time of change, and a checksum of the first 4
/// KiB, where a header is. Folders and files that are not there are left out.
class FileStamps {
 public:
  static FileStamps of(const std::vector<std::filesystem::path>& paths);

  /// Whether all are the same still. `with_checksums`: the beginnings are read again as well; the
  /// rest costs a call of the system for each file. Errors: io_error, which names the first that
  /// has changed.
  Result<void> check(bool with_checksums = true) const;

 private:
  struct Stamp {
    std::filesystem::path path;
    FileIdentity identity;
    uint64_t checksum = 0;
  };

  std::vector<Stamp> stamps_;
};

/// A source that gives the slices of another, and io_error once a file of it has changed since this
/// call: a store is not built of two volumes.
std::unique_ptr<VolumeSource> watch_files(std::unique_ptr<VolumeSource> source);

}  // namespace isosplat
