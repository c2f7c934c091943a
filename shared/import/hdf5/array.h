#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/hdf5/layout.h"

namespace isosplat::import {

constexpr size_t kNoHdf5Axis = ~size_t{0};

/// The part of an array that is read: three axes from their first element on, and one element along
/// each of the other axes.
struct Hdf5Part {
  std::array<size_t, 3> axes{};     ///< of the array, the slowest first; kNoHdf5Axis: none
  std::array<uint64_t, 3> sizes{};  ///< elements along them, at most the array's
  std::vector<uint64_t> at;  ///< the element along each axis of the array; 0 along those three
};

/// Reads a part of an array as if it was stored separately, in row-major order. Keeps the chunks of
/// the last layer, unless they take more than 512 MiB; in that case, each read decodes all chunks
/// that it touches. Errors: those of read_hdf5_chunks; malformed_volume if no element exists.
Result<std::unique_ptr<ByteReader>> open_hdf5_array(std::shared_ptr<Hdf5File> file,
                                                    Hdf5Layout layout, Hdf5Part part);

/// All numbers of a small dataset, in row-major order: at most 2^20. Nothing if it is no such
/// dataset, or none of it was written. `sizes` becomes its sizes. Errors: those of reading it.
Result<std::optional<std::vector<double>>> hdf5_small_array(const std::shared_ptr<Hdf5File>& file,
                                                            const Hdf5Object& object,
                                                            std::vector<uint64_t>& sizes);

}  // namespace isosplat::import
