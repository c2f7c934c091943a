#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "shared/core/grid/volume_source.h"
#include "shared/import/bytes/input_files.h"

namespace isosplat::import {

/// The state of files at one time: size, modification time, and a checksum of the first 4 KiB,
/// which contain the header. Folders and missing files are ignored.
class FileStamps {
 public:
  static FileStamps of(const std::vector<std::filesystem::path>& paths);

  /// Checks that no file has changed. `with_checksums`: also reads the beginnings of the files
  /// again; without it, the check takes one system call per file. Errors: io_error, which names the
  /// first file that has changed.
  Result<void> check(bool with_checksums = true) const;

 private:
  struct Stamp {
    std::filesystem::path path;
    InputState state;
    uint64_t checksum = 0;
  };

  std::vector<Stamp> stamps_;
};

/// A source that returns the slices of another source, and io_error once one of its files has
/// changed since this call. This prevents a store with data of two volumes.
std::unique_ptr<VolumeSource> watch_files(std::unique_ptr<VolumeSource> source);

}  // namespace isosplat::import
