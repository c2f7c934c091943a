#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "shared/base/status.h"

// What the program may write over. It never writes to a file that it reads, whatever names, links
// and hard links lead to it; and it replaces a file that it has not made only with --force.
namespace isosplat::cli {

/// Errors: invalid_argument where `output` is one of the files that are read.
Result<void> check_not_input(const std::filesystem::path& output,
                             std::span<const std::filesystem::path> inputs);

/// Whether `output` may be written: there is no such file, it is empty, or it begins with
/// `beginning`, as files of its kind ("a PLY file") do; any file with `force`. Errors:
/// invalid_argument.
Result<void> check_replaceable(const std::filesystem::path& output, std::string_view beginning,
                               std::string_view kind, bool force);

/// A volume's path as a store's metadata has it (FORMAT.md, META): XXH3-64 of the path from the
/// store's folder, links resolved, as 16 hexadecimal digits.
std::string source_path_hash(const std::filesystem::path& volume,
                             const std::filesystem::path& store);

/// Whether a store of this source may be written: there is no such file, it is empty, or a store of
/// the same source; any file with `force`. Errors: invalid_argument.
Result<void> check_replaceable_store(const std::filesystem::path& store,
                                     std::string_view source_path_hash, bool force);

}  // namespace isosplat::cli
