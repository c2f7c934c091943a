#include "native/python/read_values.h"

#include <algorithm>
#include <atomic>

#include "native/extract/chunk_reading.h"
#include "shared/core/points/chunk_shape.h"

namespace isosplat::python {
namespace {

/// An array of the values in a box.
template <class Scalar>
struct ValueArray {
  const VoxelBox& box;
  const ValueMapping& mapping;
  std::span<Scalar> values;

  /// The low corner of a block or cell, in the box.
  Index3 inside(Index3 voxel) const {
    const Index3 first = box.first;
    return {voxel.x - first.x, voxel.y - first.y, voxel.z - first.z};
  }

  /// Cells of several threads share corners, whose value is the same in all of them.
  void set(Index3 at, QuantizedValue quantized) {
    if (at.x < 0 || at.y < 0 || at.z < 0) return;
    if (at.x >= box.count.x || at.y >= box.count.y || at.z >= box.count.z) return;
    if (mapping.has_missing && quantized == kMissingVoxel) return;
    const size_t row =
        static_cast<size_t>(at.z) * static_cast<size_t>(box.count.y) + static_cast<size_t>(at.y);
    const size_t index = row * static_cast<size_t>(box.count.x) + static_cast<size_t>(at.x);
    std::atomic_ref(values[index])
        .store(static_cast<Scalar>(mapping.value(quantized)), std::memory_order_relaxed);
  }

  void set(const DecodedCells& cells, Index3 origin) {
    for (size_t i = 0; i < cells.cell.size(); ++i) {
      const uint32_t cell = cells.cell[i];
      const Index3 low = inside(origin + Index3{static_cast<int32_t>(cell & 63),
                                                static_cast<int32_t>(cell >> 6 & 63),
                                                static_cast<int32_t>(cell >> 12)});
      for (int32_t corner = 0; corner < 8; ++corner) {
        set(low + Index3{corner & 1, corner >> 1 & 1, corner >> 2},
            cells.corners[i][static_cast<size_t>(corner)]);
      }
    }
  }
};

template <class Scalar>
Result<void> read_all(const StoreFile& store, const ExtractOptions& options,
                      const std::function<Result<void>()>& check, ValueArray<Scalar> array) {
  const StoreInfo& info = store.info();
  // Voxel i is a corner of cells i − 1 and i.
  const Index3 first = array.box.first, count = array.box.count;
  const auto first_block = [](int32_t voxel) { return std::max(0, voxel - 1) / kBlockCells; };
  const auto end_block = [](int32_t end) { return (end - 1) / kBlockCells + 1; };
  const BlockRange blocks{
      {first_block(first.x), first_block(first.y), first_block(first.z)},
      {end_block(first.x + count.x), end_block(first.y + count.y), end_block(first.z + count.z)}};
  // Intervals of coarse cells may be wider than the range of the values.
  auto selection = store.chunks_for(options.level, 0, 65535, {}, nullptr, blocks);
  if (!selection) return tl::unexpected(selection.error());
  std::vector<ChunkRef>& chunks = selection->chunks;
  std::erase_if(chunks, [](const ChunkRef& chunk) { return chunk.cells == 0; });
  const unsigned threads = thread_count(options, chunks.size());
  std::vector<DecodedCells> decoded_cells(threads);
  const auto read = [&](std::span<const ChunkRef> batch) {
    return for_each_chunk(store, batch, threads,
                          [&](unsigned thread, ChunkDecoder& decoder,
                              std::span<const std::byte> bytes, size_t i) -> Result<void> {
                            DecodedCells& cells = decoded_cells[thread];
                            auto decoded = decode_cells(decoder, bytes, batch[i],
                                                        shape_of(info, batch[i]), options, cells);
                            if (decoded) array.set(cells, origin_of(batch[i].block));
                            return decoded;
                          });
  };
  const auto take = [&](std::span<const ChunkRef> batch, size_t i) {
    return i + 1 == batch.size() ? check() : Result<void>{};
  };
  return for_each_batch(chunks, read, take);
}

}  // namespace

template <class Scalar>
Result<void> read_values(const StoreFile& store, const VoxelBox& box, const ExtractOptions& options,
                         const std::function<Result<void>()>& check, std::span<Scalar> values) {
  return catch_out_of_memory(store, [&] {
    return read_all(store, options, check, ValueArray<Scalar>{box, store.info().mapping, values});
  });
}

template Result<void> read_values(const StoreFile&, const VoxelBox&, const ExtractOptions&,
                                  const std::function<Result<void>()>&, std::span<float>);
template Result<void> read_values(const StoreFile&, const VoxelBox&, const ExtractOptions&,
                                  const std::function<Result<void>()>&, std::span<double>);

}  // namespace isosplat::python
