#include <algorithm>
#include <optional>

#include "shared/import/hdf5/index.h"
#include "shared/import/hdf5/layout.h"
#include "shared/import/hdf5/records.h"
#include "shared/import/hdf5/tree.h"

// The indices of an array's chunks.
//
// tree     a node (tree.h):
//          (key, address: a node of the level below, or a chunk) × entries, key
//          a key: u32 bytes of the chunk, u32 mask, u64 × axes: its first element, u64 0
// records  a B-tree of version 2 (records.h):
//          address; with filters bytes of the chunk, u32 mask;
//          u64 × axes: the index of the chunk along each axis
// arrays   index.h: an entry's number counts the chunks that the array may have.
//          In an array that can grow along one axis, that axis is the slowest one.
namespace isosplat::import {
namespace {

using Chunks = std::vector<Hdf5Chunk>;

/// The number of chunks of an array with these sizes.
uint64_t count_of(const Hdf5Layout& layout, const std::vector<uint64_t>& sizes) {
  uint64_t count = 1;
  for (size_t axis = 0; axis < sizes.size(); ++axis) {
    const uint64_t along =
        sizes[axis] / layout.chunk[axis] + (sizes[axis] % layout.chunk[axis] > 0);
    if (__builtin_mul_overflow(count, along, &count)) return kHdf5Undefined;
  }
  return count;
}

/// Adds a chunk with these indices along the axes. An array that was shortened may keep others.
void take_chunk(const Hdf5Layout& layout, std::span<const uint64_t> place, Hdf5Chunk chunk,
                Chunks& chunks) {
  for (size_t axis = 0; axis < place.size(); ++axis) {
    if (place[axis] >= layout.chunks_along(axis)) return;
    chunk.number = chunk.number * layout.chunks_along(axis) + place[axis];
  }
  chunks.push_back(chunk);
}

/// Computes the indices of a chunk along the axes from its number in an array of chunks.
class Places {
 public:
  explicit Places(const Hdf5Layout& layout) : place_(layout.sizes.size()) {
    for (size_t axis = 0; axis < place_.size(); ++axis) order_.push_back(axis);
    const auto growing = std::find(layout.limits.begin(), layout.limits.end(), kHdf5Undefined);
    if (layout.index == Hdf5Layout::Index::growing && growing != layout.limits.end()) {
      const auto first = order_.begin();
      std::rotate(first, first + (growing - layout.limits.begin()),
                  first + (growing - layout.limits.begin()) + 1);
    }
    for (const size_t axis : order_) {
      const uint64_t limit = layout.limits[axis], chunk = layout.chunk[axis];
      along_.push_back(limit / chunk + (limit % chunk > 0));
    }
  }

  std::span<const uint64_t> place_of(uint64_t index) {
    for (size_t i = order_.size(); i-- > 0;) {
      place_[order_[i]] = i == 0 ? index : index % along_[i];
      index /= along_[i];
    }
    return place_;
  }

 private:
  std::vector<size_t> order_;    ///< the axes, the slowest first
  std::vector<uint64_t> along_;  ///< maximum numbers of chunks along them, in this order
  std::vector<uint64_t> place_;
};

/// `level`: the required level of the node; any level for the root.
Result<void> take_tree(Hdf5File& file, const Hdf5Layout& layout, uint64_t address,
                       std::optional<uint64_t> level, Chunks& chunks) {
  const auto node = read_hdf5_tree_node(file, address, Hdf5TreeKind::array, level);
  if (!node) return tl::unexpected(node.error());
  const size_t axes = layout.sizes.size();
  const uint64_t entry_bytes = 8 + 8 * (axes + 1) + file.address_bytes();
  const auto entries = file.read(node->entries, node->count * entry_bytes);
  if (!entries) return tl::unexpected(entries.error());
  Hdf5Fields fields = file.fields(*entries);
  for (uint64_t i = 0; i < node->count; ++i) {
    Hdf5Chunk chunk;
    chunk.bytes = fields.number(4);
    chunk.mask = static_cast<uint32_t>(fields.number(4));
    std::vector<uint64_t> place(axes);
    for (size_t axis = 0; axis < axes; ++axis) {
      const uint64_t first = fields.number(8);
      if (node->level == 0 && first % layout.chunk[axis] != 0) {
        return file.malformed("a chunk is not at a multiple of its size");
      }
      place[axis] = first / layout.chunk[axis];
    }
    fields.skip(8);
    chunk.address = fields.address();
    if (node->level > 0) {
      auto taken = take_tree(file, layout, chunk.address, node->level - 1, chunks);
      if (!taken) return taken;
    } else {
      take_chunk(layout, place, chunk, chunks);
    }
  }
  return {};
}

Result<void> take_records(Hdf5File& file, const Hdf5Layout& layout, Chunks& chunks) {
  const bool has_filters = !layout.filters.empty();
  const size_t axes = layout.sizes.size();
  const uint64_t least = file.address_bytes() + 8 * axes + (has_filters ? 5 : 0);
  std::vector<uint64_t> place(axes);
  const auto take = [&](std::span<const std::byte> record) -> Result<void> {
    Hdf5Fields fields = file.fields(record);
    Hdf5Chunk chunk;
    chunk.address = fields.address();
    chunk.bytes = layout.chunk_bytes();
    if (has_filters) {
      const uint64_t size_bytes = record.size() - least + 1;
      if (size_bytes > 8) return file.malformed("the index of an array's chunks is damaged");
      chunk.bytes = fields.number(size_bytes);
      chunk.mask = static_cast<uint32_t>(fields.number(4));
    }
    for (uint64_t& along : place) along = fields.number(8);
    take_chunk(layout, place, chunk, chunks);
    return {};
  };
  return visit_hdf5_records(file, layout.address,
                            has_filters ? Hdf5RecordKind::packed_chunk : Hdf5RecordKind::chunk,
                            least, take);
}

}  // namespace

Result<Chunks> read_hdf5_chunks(Hdf5File& file, const Hdf5Layout& layout) {
  using Index = Hdf5Layout::Index;
  Chunks chunks;
  if (layout.address == kHdf5Undefined) return chunks;
  const uint64_t bytes = layout.chunk_bytes();
  const uint64_t count = count_of(layout, layout.limits);
  Places places(layout);
  const auto take = [&](const Hdf5ChunkEntry& entry) -> Result<void> {
    take_chunk(layout, places.place_of(entry.index), {0, entry.address, entry.bytes, entry.mask},
               chunks);
    return {};
  };
  Result<void> taken;
  if (layout.index == Index::tree) {
    taken = take_tree(file, layout, layout.address, std::nullopt, chunks);
  } else if (layout.index == Index::fixed) {
    taken = visit_hdf5_fixed_array(file, layout, count, take);
  } else if (layout.index == Index::growing) {
    taken = visit_hdf5_growing_array(file, layout, take);
  } else if (layout.index == Index::records) {
    taken = take_records(file, layout, chunks);
  } else if (layout.index == Index::single) {
    if (count_of(layout, layout.sizes) != 1) {
      return file.malformed("an array with one chunk is larger than it");
    }
    chunks.push_back({0, layout.address, layout.single_bytes, layout.single_mask});
  } else {
    if (!layout.filters.empty() || count > file.bytes() / bytes) {
      return file.malformed("the chunks of an array are not in the file");
    }
    for (uint64_t i = 0; i < count && taken; ++i) {
      taken = take({i, layout.address + i * bytes, bytes, 0});
    }
  }
  if (!taken) return tl::unexpected(taken.error());
  const auto by_number = [](const Hdf5Chunk& a, const Hdf5Chunk& b) { return a.number < b.number; };
  std::sort(chunks.begin(), chunks.end(), by_number);
  const auto twice = std::adjacent_find(
      chunks.begin(), chunks.end(),
      [](const Hdf5Chunk& a, const Hdf5Chunk& b) { return a.number == b.number; });
  if (twice != chunks.end()) return file.malformed("the index of an array has a chunk twice");
  return chunks;
}

}  // namespace isosplat::import
