#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"
#include "shared/system/store_file/store_file.h"

// Rules for overwriting files. The program never overwrites a file that it reads, even through
// another name, a symbolic link or a hard link. It replaces a file of another kind only with
// --force.
namespace isosplat::cli {

/// Errors: invalid_argument if `output` is one of the input files.
Result<void> check_not_input(const std::filesystem::path& output,
                             std::span<const std::filesystem::path> inputs);

/// Checks that `output` may be written: it does not exist, it is empty, or it begins with
/// `beginning`, as all files of this kind do. `kind`: for the message, such as "a PLY file".
/// `force`: any file may be replaced. Errors: invalid_argument.
Result<void> check_replaceable(const std::filesystem::path& output, std::string_view beginning,
                               std::string_view kind, bool force);

/// Checks that a bundle may be written: as check_replaceable, for files of isosplat bundle and
/// build.
Result<void> check_replaceable_bundle(const std::filesystem::path& output, bool force);

/// The file and the hash of the path from which a store was built, as in its metadata; empty if it
/// does not state them.
struct StoredSource {
  std::string file, path_hash;
};
StoredSource source_of(const StoreFile& store);

/// Checks that a store of this source may be written: the file does not exist, it is empty, or it
/// is a store of the same source. `force`: any file may be replaced. Errors: invalid_argument.
Result<void> check_replaceable_store(const std::filesystem::path& store,
                                     std::string_view source_path_hash, bool force);

}  // namespace isosplat::cli
