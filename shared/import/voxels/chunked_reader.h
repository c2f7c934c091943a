#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

constexpr size_t kNoAxis = ~size_t{0};

/// The part of an array that is read: three axes from their first element on, and one element along
/// each of the other axes.
struct ArrayPart {
  std::array<size_t, 3> axes{};     ///< of the array, the slowest first; kNoAxis: none
  std::array<uint64_t, 3> sizes{};  ///< elements along them, at most the array's
  std::vector<uint64_t> at;  ///< the element along each axis of the array; 0 along those three
};

/// An array whose elements are stored in chunks of one size; those at the end of an axis may reach
/// beyond it.
struct ChunkGrid {
  std::vector<uint64_t> sizes;       ///< of the array along its axes, from the first one on
  std::vector<uint64_t> chunk;       ///< of a chunk; above 0
  uint64_t element_bytes = 1;        ///< at most 16
  std::vector<std::byte> fill = {};  ///< an element of chunks that do not exist; empty: 0
  /// The axes in a decoded chunk, the slowest first; empty: in their order.
  std::vector<size_t> order = {};

  /// Saturates at the largest uint64_t.
  uint64_t chunk_bytes() const;
  uint64_t chunks_along(size_t axis) const { return (sizes[axis] + chunk[axis] - 1) / chunk[axis]; }
};

/// Reads a part of an array in chunks as if it was stored separately, in row-major order. Keeps the
/// chunks of the last layer, unless they take more than 512 MiB; in that case, each read decodes
/// all chunks that it touches.
class ChunkedReader : public ByteReader {
 public:
  Result<void> read(uint64_t offset, std::span<std::byte> out) final;
  // Otherwise, a chunk is decoded once for each of its slices.
  bool is_random_access() const final { return keeps_layer_ || axes_[0].chunk == 1; }
  uint64_t size_limit() const final { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) final;
  uint64_t available_bytes() final { return bytes_; }
  uint64_t resident_bytes() const override;

 protected:
  /// `name`: of the file, for messages.
  ChunkedReader(std::string name, ChunkGrid grid, const ArrayPart& part);

  const ChunkGrid& grid() const { return grid_; }

  /// The elements of a chunk, chunk_bytes() of them; empty if it does not exist. `number`: of all
  /// chunks, in row-major order. is_at_edge: it reaches beyond the end of an axis. Errors: those of
  /// ByteReader::read.
  virtual Result<std::vector<std::byte>> decode(uint64_t number, bool is_at_edge) = 0;

  /// The numbers of all chunks of the part.
  std::vector<uint64_t> numbers() const;

 private:
  /// The elements of a chunk along one axis.
  struct Axis {
    uint64_t size = 1;         ///< elements that are read
    uint64_t whole = 1;        ///< elements of the array
    uint64_t chunk = 1;        ///< elements of a chunk
    uint64_t chunks = 1;       ///< number of chunks to read
    uint64_t step = 0;         ///< from an element to the next one in a chunk, in elements
    uint64_t chunks_step = 0;  ///< from a chunk to the next one, in numbers of chunks
  };

  struct Range {
    uint64_t first_z, last_z, first_y, last_y;
  };

  uint64_t number_of(uint64_t cz, uint64_t cy, uint64_t cx) const;
  Result<std::span<const std::byte>> chunk_at(uint64_t cz, uint64_t cy, uint64_t cx);
  bool is_at_edge(uint64_t cz, uint64_t cy, uint64_t cx) const;
  void copy(std::span<const std::byte> elements, const std::array<uint64_t, 3>& at,
            const Range& range, uint64_t offset, std::span<std::byte> out) const;
  std::span<const std::byte> element_at(std::span<const std::byte> elements, uint64_t i) const;

  std::string name_;
  ChunkGrid grid_;
  std::array<Axis, 3> axes_;  ///< the slowest first
  /// The number of the part's first chunk, and the part's first element in each chunk.
  uint64_t first_chunk_ = 0, first_element_ = 0;
  bool is_at_edge_ = false;  ///< all chunks of the part reach beyond the end of an axis
  uint64_t bytes_ = 0;
  bool keeps_layer_ = false;
  uint64_t layer_z_ = ~uint64_t{0};

  struct Kept {
    bool is_read = false;
    std::vector<std::byte> elements;
  };
  std::vector<Kept> layer_;
  Kept single_;
};

}  // namespace isosplat::import
