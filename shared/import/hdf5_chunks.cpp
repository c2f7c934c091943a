
#include <algorithm>
#include <optional>

#include "shared/import/hdf5_checksums.h"
#include "shared/import/hdf5_layout.h"
#include "shared/import/hdf5_tree.h"

// The indices of an array's chunks.
//
// tree   a node (hdf5_tree.h):
//        (key, address: a node of the level below, or a chunk) × entries, key
//        a key: u32 bytes of the chunk, u32 mask, u64 × axes: its first element, u64 0
// fixed  "FAHD", u8 0, u8 kind (1: with filters), u8 bytes of an entry, u8 bits of a page,
//        length: entries, address: its data, u32 checksum
//        data: "FADB", u8 0, u8 kind, address of the header,
//              without pages: the entries, u32 checksum
//              with pages: a bit for each page, u32 checksum; pages: entries, u32 checksum
//        an entry: address; with filters also bytes of the chunk, u32 mask
namespace isosplat {
namespace {

using Chunks = std::vector<Hdf5Chunk>;

/// How many chunks the array has.
uint64_t count_of(const Hdf5Layout& layout) {
  uint64_t count = 1;
  for (size_t axis = 0; axis < layout.sizes.size(); ++axis) {
    if (__builtin_mul_overflow(count, layout.chunks_along(axis), &count)) return kHdf5Undefined;
  }
  return count;
}

/// `level`: that the node must have; any, if it is the root's.
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
    bool is_inside = true;
    for (size_t axis = 0; axis < axes; ++axis) {
      const uint64_t first = fields.number(8);
      if (node->level == 0 && first % layout.chunk[axis] != 0) {
        return file.malformed("a chunk is not at a multiple of its size");
      }
      is_inside = is_inside && first < layout.sizes[axis];
      chunk.number = chunk.number * layout.chunks_along(axis) + first / layout.chunk[axis];
    }
    fields.skip(8);
    chunk.address = fields.address();
    if (node->level > 0) {
      auto taken = take_tree(file, layout, chunk.address, node->level - 1, chunks);
      if (!taken) return taken;
    } else if (is_inside) {  // an array that was shortened may keep others
      chunks.push_back(chunk);
    }
  }
  return {};
}

Result<void> take_fixed(Hdf5File& file, const Hdf5Layout& layout, Chunks& chunks) {
  const auto checked = [&](std::span<const std::byte> bytes) {
    Hdf5Fields end = file.fields(bytes.last(4));
    return end.number(4) == hdf5_lookup3(bytes.first(bytes.size() - 4));
  };
  const auto damaged = [&] { return file.malformed("the index of an array's chunks is damaged"); };
  const auto head = file.read(layout.address, 12 + file.length_bytes() + file.address_bytes());
  if (!head) return tl::unexpected(head.error());
  Hdf5Fields fields = file.fields(*head);
  if (fields.text(4) != "FAHD" || !checked(*head)) return damaged();
  fields.skip(1);
  const bool has_filters = fields.number(1) == 1;
  const uint64_t entry_bytes = fields.number(1), page_bits = fields.number(1);
  const uint64_t count = fields.length(), data = fields.address();
  const uint64_t least = file.address_bytes() + (has_filters ? 5 : 0);
  if (count != count_of(layout) || page_bits > 30 || entry_bytes < least ||
      entry_bytes > least + 7 || (!has_filters && entry_bytes != least) ||
      has_filters == layout.filters.empty()) {
    return damaged();
  }
  if (data == kHdf5Undefined) return {};
  const auto take = [&](std::span<const std::byte> entries, uint64_t first) {
    Hdf5Fields each = file.fields(entries);
    for (uint64_t number = first; each.left() >= entry_bytes; ++number) {
      Hdf5Chunk chunk{number, each.address(), layout.chunk_bytes(), 0};
      if (has_filters) {
        chunk.bytes = each.number(entry_bytes - file.address_bytes() - 4);
        chunk.mask = static_cast<uint32_t>(each.number(4));
      }
      if (chunk.address != kHdf5Undefined) chunks.push_back(chunk);
    }
  };
  const uint64_t prefix = 6 + file.address_bytes(), per_page = uint64_t{1} << page_bits;
  if (count > file.bytes() / entry_bytes) return damaged();
  const uint64_t pages = count > per_page ? (count + per_page - 1) / per_page : 0;
  const uint64_t first_bytes = prefix + (pages > 0 ? (pages + 7) / 8 : count * entry_bytes) + 4;
  const auto first = file.read(data, first_bytes);
  if (!first) return tl::unexpected(first.error());
  fields = file.fields(*first);
  if (fields.text(4) != "FADB" || !checked(*first)) return damaged();
  const auto inner =
      std::span(*first).first(first->size() - 4).subspan(static_cast<size_t>(prefix));
  if (pages == 0) {
    take(inner, 0);
    return {};
  }
  uint64_t begin = data + first_bytes;
  for (uint64_t page = 0; page < pages; ++page) {
    const uint64_t entries = std::min(per_page, count - page * per_page);
    const uint64_t bytes = entries * entry_bytes + 4;
    // The highest bit is the first page's. Pages that were not written have no checksum.
    const bool exists =
        (inner[static_cast<size_t>(page / 8)] & std::byte(0x80 >> page % 8)) != std::byte{0};
    if (exists) {
      const auto content = file.read(begin, bytes);
      if (!content) return tl::unexpected(content.error());
      if (!checked(*content)) return damaged();
      take(std::span(*content).first(content->size() - 4), page * per_page);
    }
    begin += bytes;
  }
  return {};
}

}  // namespace

Result<Chunks> read_hdf5_chunks(Hdf5File& file, const Hdf5Layout& layout) {
  using Index = Hdf5Layout::Index;
  Chunks chunks;
  if (layout.address == kHdf5Undefined) return chunks;
  const uint64_t bytes = layout.chunk_bytes();
  Result<void> taken;
  if (layout.index == Index::tree) {
    taken = take_tree(file, layout, layout.address, std::nullopt, chunks);
  } else if (layout.index == Index::fixed) {
    taken = take_fixed(file, layout, chunks);
  } else if (layout.index == Index::single) {
    if (count_of(layout) != 1) return file.malformed("an array with one chunk is larger than it");
    chunks.push_back({0, layout.address, layout.single_bytes, layout.single_mask});
  } else {
    const uint64_t count = count_of(layout);
    if (!layout.filters.empty() || count > file.bytes() / bytes) {
      return file.malformed("the chunks of an array are not in the file");
    }
    for (uint64_t i = 0; i < count; ++i)
      chunks.push_back({i, layout.address + i * bytes, bytes, 0});
  }
  if (!taken) return tl::unexpected(taken.error());
  // Every index has them in order.
  for (size_t i = 1; i < chunks.size(); ++i) {
    if (chunks[i].number <= chunks[i - 1].number) {
      return file.malformed("the chunks of an array are not in order");
    }
  }
  return chunks;
}

}  // namespace isosplat
