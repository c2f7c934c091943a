#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"

/// The files from which volumes are read: those of the system (system_files.cpp), or in a browser
/// those that the user has chosen (shared/bindings/wasm/import_files.cpp). All other code in
/// shared/import opens files through these functions.
namespace isosplat::import {

/// An open file; the destructor closes it.
class InputFile {
 public:
  virtual ~InputFile() = default;

  /// Reads out.size() bytes, or fewer if the file ends. Returns their number. Errors: io_error.
  virtual Result<size_t> read_some(uint64_t offset, std::span<std::byte> out) const = 0;
};

/// Opens a regular file. Errors: io_error, also for folders, pipes and devices.
Result<std::unique_ptr<InputFile>> open_input(const std::filesystem::path& path);

/// The properties of a file that change when it is written.
struct InputState {
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< since 1970
};

/// The state of the regular file at a path. Errors: those of open_input.
Result<InputState> input_state(const std::filesystem::path& path);

enum class InputKind : uint8_t { none, file, folder, other };

/// The kind of the object at a path, after links are resolved. None if it cannot be determined.
InputKind input_kind(const std::filesystem::path& path);

struct FolderEntry {
  std::filesystem::path path;  ///< the folder's path and the name
  InputKind kind = InputKind::none;
};

/// The entries of a folder, in any order; empty if it cannot be read.
std::vector<FolderEntry> folder_entries(const std::filesystem::path& folder);

}  // namespace isosplat::import
