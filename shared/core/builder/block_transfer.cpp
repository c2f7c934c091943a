#include "shared/core/builder/block_transfer.h"

#include <algorithm>
#include <cstring>

#include "shared/core/preprocess/coarse_voxels.h"

namespace isosplat {
namespace {

struct TaskHeader {
  double storage_weight, overhead_cells, max_bytes;
  uint32_t max_candidates;
  uint32_t number;
  uint32_t level, bits, has_missing, has_coarser;
  int32_t volume[3];  ///< voxels of level 0
  int32_t index[3];
  uint32_t only_isovalue;  ///< kAnyIsovalue: the store is for all isovalues
  uint32_t reserved;
};

/// The value of TaskHeader::only_isovalue for a store of all isovalues.
constexpr uint32_t kAnyIsovalue = 65536;

struct EncodedHeader {
  double storage_weight, task_weight, max_bytes;
  uint32_t number;
  uint32_t min, max;
  uint32_t bands, bytes;
  uint32_t reserved;
};

tl::unexpected<Error> malformed(const char* what) {
  return fail(Status::invalid_argument,
              std::string(what) + " of another version, or incomplete: load the page again");
}

template <class T>
void append(std::vector<std::byte>& to, const T* items, size_t count) {
  const size_t begin = to.size();
  to.resize(begin + count * sizeof(T));
  if (count > 0) std::memcpy(to.data() + begin, items, count * sizeof(T));
}

/// Takes parts of a message, front to back.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  /// The next bytes; null if the message ends before.
  const std::byte* take(size_t bytes) {
    if (bytes > left_.size()) return nullptr;
    const std::byte* at = left_.data();
    left_ = left_.subspan(bytes);
    return at;
  }
  template <class T>
  bool copy(T* items, size_t count) {
    const std::byte* from = take(sizeof(T) * count);
    if (from && count > 0) std::memcpy(items, from, sizeof(T) * count);
    return from != nullptr;
  }
  bool is_empty() const { return left_.empty(); }

 private:
  std::span<const std::byte> left_;
};

/// The voxels that a block needs: its own, and those before it, for the coarser level.
LevelBox voxels_of(const LevelGrid& grid, Index3 block) {
  LevelBox box;
  const Index3 cells = block_cells(grid, block);
  const auto along = [](int32_t index, int32_t count, int32_t& first, int32_t& size) {
    first = std::max(index * kBlockCells - kVoxelsBefore, 0);
    size = index * kBlockCells + count + 1 - first;
  };
  along(block.x, cells.x, box.first.x, box.size.x);
  along(block.y, cells.y, box.first.y, box.size.y);
  along(block.z, cells.z, box.first.z, box.size.z);
  return box;
}

LevelBox cells_of(const LevelGrid& grid, Index3 block) {
  return {{block.x * kBlockCells, block.y * kBlockCells, block.z * kBlockCells},
          block_cells(grid, block)};
}

/// The index of a block in its level, from its number in the layer of blocks.
Index3 index_of(const Layer& layer, size_t number) {
  const auto n = static_cast<int32_t>(number);
  return {n % layer.grid.blocks.x, n / layer.grid.blocks.x,
          (layer.voxel_box.first.z + kVoxelsBefore) / kBlockCells};
}

bool contains(const LevelBox& outer, const LevelBox& inner) {
  const auto along = [](int32_t first, int32_t size, int32_t in_first, int32_t in_size) {
    return in_first >= first && in_first + in_size <= first + size;
  };
  return along(outer.first.x, outer.size.x, inner.first.x, inner.size.x) &&
         along(outer.first.y, outer.size.y, inner.first.y, inner.size.y) &&
         along(outer.first.z, outer.size.z, inner.first.z, inner.size.z);
}

/// Calls row(index in the large box, index in the small box) for each row of the small box.
template <class F>
void for_each_row(const LevelBox& large, const LevelBox& small, F row) {
  for (int32_t z = 0; z < small.size.z; ++z) {
    for (int32_t y = 0; y < small.size.y; ++y) {
      const Index3 p{small.first.x, small.first.y + y, small.first.z + z};
      row(large.at(p), small.at(p));
    }
  }
}

/// Appends the items of a box that is part of another.
void append_box(std::vector<std::byte>& to, const std::byte* items, size_t item_bytes,
                const LevelBox& of, const LevelBox& box) {
  const size_t begin = to.size(), row = static_cast<size_t>(box.size.x) * item_bytes;
  to.resize(begin + box.count() * item_bytes);
  std::byte* const out = to.data() + begin;
  for_each_row(of, box, [&](size_t from, size_t at) {
    std::memcpy(out + at * item_bytes, items + from * item_bytes, row);
  });
}

/// Copies a box to its position in another box that contains it.
void place_box(const std::byte* from, size_t item_bytes, const LevelBox& box, std::byte* items,
               const LevelBox& in) {
  const size_t row = static_cast<size_t>(box.size.x) * item_bytes;
  for_each_row(in, box, [&](size_t to, size_t at) {
    std::memcpy(items + to * item_bytes, from + at * item_bytes, row);
  });
}

/// Appends an encoded block without its part of the coarser level.
void append_encoded(std::vector<std::byte>& to, size_t number, const EncodedBlock& encoded) {
  const EncodedHeader header{encoded.storage_weight,
                             encoded.task_weight,
                             encoded.max_bytes,
                             static_cast<uint32_t>(number),
                             encoded.interval.min,
                             encoded.interval.max,
                             static_cast<uint32_t>(encoded.bands.size()),
                             static_cast<uint32_t>(encoded.bytes.size()),
                             0};
  append(to, &header, 1);
  append(to, encoded.bands.data(), encoded.bands.size());
  append(to, encoded.bytes.data(), encoded.bytes.size());
}

bool is_valid(const TaskHeader& task) {
  for (const int32_t voxels : task.volume) {
    if (voxels < 2 || voxels > kMaxVoxelsPerAxis) return false;
  }
  if (task.only_isovalue > kAnyIsovalue) return false;
  const Index3 volume{task.volume[0], task.volume[1], task.volume[2]};
  const uint32_t levels = level_count(volume);
  if (task.level >= levels || (task.bits != 8 && task.bits != 16)) return false;
  if (task.has_coarser != (task.level + 1 < levels ? 1u : 0u)) return false;
  const Index3 blocks = level_grid(volume, task.level).blocks;
  const auto is_inside = [](int32_t index, int32_t count) { return index >= 0 && index < count; };
  return is_inside(task.index[0], blocks.x) && is_inside(task.index[1], blocks.y) &&
         is_inside(task.index[2], blocks.z);
}

}  // namespace

void write_task(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
                Index3 volume, std::vector<std::byte>& message) {
  message.clear();
  const TaskHeader header{task.options.storage_weight,
                          task.options.overhead_cells,
                          task.max_bytes,
                          task.options.max_candidates,
                          static_cast<uint32_t>(task.number),
                          layer.grid.level,
                          layer.bits,
                          layer.has_missing,
                          coarser.voxels != nullptr,
                          {volume.x, volume.y, volume.z},
                          {task.index.x, task.index.y, task.index.z},
                          layer.only_isovalue ? *layer.only_isovalue : kAnyIsovalue,
                          0};
  append(message, &header, 1);
  const size_t value_bytes = layer.bits / 8;
  append_box(message, layer.voxels, value_bytes, layer.voxel_box,
             voxels_of(layer.grid, task.index));
  if (layer.intervals) {
    append_box(message, layer.intervals, 2 * value_bytes, layer.cell_box,
               cells_of(layer.grid, task.index));
  }
}

Result<void> encode_task(std::span<const std::byte> task,
                         std::span<const double> isovalue_distribution, BlockEncoder& encoder,
                         std::vector<std::byte>& message) {
  Reader reader(task);
  TaskHeader header{};
  if (!reader.copy(&header, 1) || !is_valid(header)) return malformed("the task of an encoder is");
  const Index3 volume{header.volume[0], header.volume[1], header.volume[2]};
  const Index3 index{header.index[0], header.index[1], header.index[2]};
  Layer layer{level_grid(volume, header.level), static_cast<uint8_t>(header.bits),
              header.has_missing != 0};
  if (header.only_isovalue != kAnyIsovalue) {
    layer.only_isovalue = static_cast<QuantizedValue>(header.only_isovalue);
  }
  const size_t value_bytes = header.bits / 8;
  layer.voxel_box = voxels_of(layer.grid, index);
  layer.voxels = reader.take(layer.voxel_box.count() * value_bytes);
  if (header.level > 0) {
    layer.cell_box = cells_of(layer.grid, index);
    layer.intervals = reader.take(layer.cell_box.count() * 2 * value_bytes);
  }
  if (!layer.voxels || (header.level > 0 && !layer.intervals) || !reader.is_empty()) {
    return malformed("the task of an encoder is");
  }

  CoarserLayer coarser;
  std::vector<std::byte> coarse_voxels, coarse_intervals;
  if (header.has_coarser) {
    coarser.grid = level_grid(volume, header.level + 1);
    coarser.voxel_box = coarse_voxels_of(layer.grid, index);
    coarser.cell_box = coarse_cells_of(layer.grid, index);
    coarse_voxels.resize(coarser.voxel_box.count() * value_bytes);
    coarse_intervals.resize(coarser.cell_box.count() * 2 * value_bytes);
    coarser.voxels = coarse_voxels.data();
    coarser.intervals = coarse_intervals.data();
  }
  BlockTask block;
  block.number = header.number;
  block.index = index;
  block.options = {header.storage_weight, header.overhead_cells, isovalue_distribution,
                   header.max_candidates};
  block.max_bytes = header.max_bytes;
  BandsEncoder bands;
  EncodedBlock encoded;
  encoder.encode(layer, coarser, block, bands, encoded);

  message.clear();
  append_encoded(message, header.number, encoded);
  append(message, coarse_voxels.data(), coarse_voxels.size());
  append(message, coarse_intervals.data(), coarse_intervals.size());
  return {};
}

void write_encoded(const Layer& layer, const CoarserLayer& coarser, size_t number,
                   const EncodedBlock& encoded, std::vector<std::byte>& message) {
  message.clear();
  append_encoded(message, number, encoded);
  if (!coarser.voxels) return;
  const size_t value_bytes = layer.bits / 8;
  const Index3 index = index_of(layer, number);
  append_box(message, coarser.voxels, value_bytes, coarser.voxel_box,
             coarse_voxels_of(layer.grid, index));
  append_box(message, coarser.intervals, 2 * value_bytes, coarser.cell_box,
             coarse_cells_of(layer.grid, index));
}

Result<size_t> read_encoded(std::span<const std::byte> message, const Layer& layer,
                            const CoarserLayer& coarser, EncodedBlock& block) {
  const auto invalid = [] { return malformed("the block of an encoder is"); };
  Reader reader(message);
  EncodedHeader header{};
  if (!reader.copy(&header, 1)) return invalid();
  const Index3 blocks = layer.grid.blocks;
  const auto across = static_cast<uint32_t>(blocks.x);
  if (header.number >= across * static_cast<uint32_t>(blocks.y)) return invalid();
  const Index3 index = index_of(layer, header.number);
  if (header.min > 65535 || header.max > 65535 || header.bands > 65536) return invalid();
  block.interval = {static_cast<QuantizedValue>(header.min),
                    static_cast<QuantizedValue>(header.max)};
  block.storage_weight = header.storage_weight;
  block.task_weight = header.task_weight;
  block.max_bytes = header.max_bytes;
  block.bands.resize(header.bands);
  if (!reader.copy(block.bands.data(), block.bands.size())) return invalid();
  const std::byte* bytes = reader.take(header.bytes);
  if (!bytes) return invalid();
  block.bytes.assign(bytes, bytes + header.bytes);
  if (coarser.voxels) {
    const size_t value_bytes = layer.bits / 8;
    const LevelBox voxels = coarse_voxels_of(layer.grid, index);
    const LevelBox cells = coarse_cells_of(layer.grid, index);
    const std::byte* from_voxels = reader.take(voxels.count() * value_bytes);
    const std::byte* from_cells = reader.take(cells.count() * 2 * value_bytes);
    if (!from_voxels || !from_cells || !contains(coarser.voxel_box, voxels) ||
        !contains(coarser.cell_box, cells)) {
      return invalid();
    }
    place_box(from_voxels, value_bytes, voxels, coarser.voxels, coarser.voxel_box);
    place_box(from_cells, 2 * value_bytes, cells, coarser.intervals, coarser.cell_box);
  }
  if (!reader.is_empty()) return invalid();
  return header.number;
}

}  // namespace isosplat
