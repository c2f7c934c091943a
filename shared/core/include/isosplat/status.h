#pragma once

/// \file
/// What can go wrong, and how functions report it.

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace isosplat {

/// Everything that can go wrong in the core. Each status has exactly one cause. There is no other
/// list: the command line, the server and the page show these names.
///
/// X(name, cause)
#define ISOSPLAT_STATUSES(X)                                                                     \
  X(ok, "no error")                                                                              \
  X(invalid_argument, "a caller passed a value outside the documented range")                    \
  X(no_cells, "the volume has an axis with fewer than two voxels, so it holds no cell")          \
  X(volume_too_large, "the volume's dimensions exceed the limits of the store format")           \
  X(not_a_store, "the first bytes are not those of a store")                                     \
  X(unsupported_version, "the store was written by a newer, incompatible version")               \
  X(truncated, "the bytes end before the structure that they announce")                          \
  X(checksum_mismatch, "the bytes differ from those whose checksum was recorded")                \
  X(malformed_header, "a field of the store's header contradicts another or exceeds its limits") \
  X(malformed_page, "a directory page contradicts the header, or itself")                        \
  X(malformed_chunk, "a chunk's bytes do not decode to the cells that the directory states")     \
  X(not_found, "no such level, block, band or page")                                             \
  X(page_not_resident, "the directory page that answers this has not been added yet")            \
  X(unsupported_format, "the file is of a kind that no reader here knows")                       \
  X(malformed_volume, "the volume file's header contradicts itself or its data")                 \
  X(unsupported_type, "the volume's voxels are of a type that is not scalar or not known")       \
  X(io_error, "the operating system refused to open, read, write or rename a file")              \
  X(out_of_memory, "the work needs more memory than it was allowed")                             \
  X(gl_error, "OpenGL could not create what the renderer needs")

/// One of ISOSPLAT_STATUSES.
enum class Status : uint32_t {
/// \cond
#define ISOSPLAT_STATUS_ENUM(name, cause) name,
  ISOSPLAT_STATUSES(ISOSPLAT_STATUS_ENUM)
#undef ISOSPLAT_STATUS_ENUM
  /// \endcond
};

/// The status's name as written in the list above, e.g. "checksum_mismatch".
[[nodiscard]] std::string_view status_name(Status status);

/// The status's cause, one sentence without a full stop.
[[nodiscard]] std::string_view status_cause(Status status);

/// A status with what was expected, what was found, where, and the remedy, in one line.
struct Error {
  Status status = Status::ok;  ///< what went wrong
  std::string message;         ///< for people
};

/// A value, or the one error that prevented it. The core does not throw. tl::expected has the
/// interface of C++23's std::expected, in one header that compiles to WebAssembly. A result type
/// defined by Isosplat would be a second one for most programs.
template <class T>
using Result = tl::expected<T, Error>;

}  // namespace isosplat
