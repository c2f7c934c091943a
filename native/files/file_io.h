#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "shared/base/status.h"

namespace isosplat {

/// io_error with errno's text: "cannot WHAT PATH: TEXT". A full disk names the remedy.
tl::unexpected<Error> system_error(const char* what, const std::filesystem::path& path);

/// Writes all bytes at an offset. Errors: io_error.
Result<void> write_fully(int file, uint64_t offset, std::span<const std::byte> bytes,
                         const std::filesystem::path& path);

/// Fills `bytes` from an offset. Errors: io_error; truncated where the file ends before.
Result<void> read_fully(int file, uint64_t offset, std::span<std::byte> bytes,
                        const std::filesystem::path& path);

}  // namespace isosplat
