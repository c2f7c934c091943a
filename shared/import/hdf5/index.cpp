#include "shared/import/hdf5/index.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "shared/import/hdf5/records.h"

// Arrays of addresses of chunks. An entry: address; with filters also bytes of the chunk, u32 mask.
//
// Of fixed size
//   header      "FAHD", u8 0, u8 kind (1: with filters), u8 bytes of an entry, u8 bits of a page,
//               length: entries, address of its data, u32 checksum
//   data        "FADB", u8 0, u8 kind, address of the header,
//               without pages: the entries, u32 checksum
//               with pages: a bit for each page, u32 checksum; pages: entries, u32 checksum
//
// That can grow ("extensible"): the first entries are in the index block, the others in data
// blocks. From level to level, the size of blocks and their number double alternately: level i has
// 2^(i/2) blocks, each of 2^((i+1)/2) times the least entries. The index block has the addresses of
// the first levels' blocks; the other levels have a super block each.
//   header      "EAHD", u8 0, u8 kind, u8 bytes of an entry, u8 bits of an index, u8 entries of the
//               index block, u8 least entries of a data block, u8 least blocks of a super block,
//               u8 bits of a page, length × 6, address of the index block, u32 checksum
//   index       "EAIB", u8 0, u8 kind, address of the header, entries, addresses of data blocks, of
//               super blocks, u32 checksum
//   super       "EASB", u8 0, u8 kind, address of the header, its first index, a bit for each page
//               of its data blocks (with room for whole bytes of each block), addresses of data
//               blocks, u32 checksum
//   data        "EADB", u8 0, u8 kind, address of the header, its first index,
//               without pages: entries, u32 checksum; with pages: u32 checksum; pages as above
namespace isosplat::import {
namespace {

/// The common part of both kinds.
class ChunkArray {
 public:
  ChunkArray(Hdf5File& file, const Hdf5Layout& layout, const Hdf5ChunkVisitor& visit)
      : file_(file), layout_(layout), visit_(visit) {}

 protected:
  tl::unexpected<Error> damaged() const {
    return file_.malformed("the index of an array's chunks is damaged");
  }

  /// Reads a block, and checks its signature, kind and checksum. Returns the fields after these.
  Result<std::vector<std::byte>> block_at(uint64_t address, uint64_t bytes,
                                          std::string_view signature) {
    auto block = file_.read(address, bytes);
    if (!block) return block;
    Hdf5Fields fields = file_.fields(*block);
    if (fields.text(4) != signature || fields.number(1) != 0 ||
        fields.number(1) != (has_filters() ? 1 : 0) || !has_hdf5_checksum(file_, *block)) {
      return damaged();
    }
    return block;
  }

  bool has_filters() const { return !layout_.filters.empty(); }

  /// Whether an entry can have this size.
  bool is_entry(uint64_t bytes) const {
    const uint64_t least = file_.address_bytes() + (has_filters() ? 5 : 0);
    return bytes >= least && bytes <= least + (has_filters() ? 7 : 0);
  }

  Result<void> take(std::span<const std::byte> entries, uint64_t first) {
    Hdf5Fields each = file_.fields(entries);
    for (uint64_t index = first; each.left() >= entry_bytes_; ++index) {
      Hdf5ChunkEntry entry{index, each.address(), layout_.chunk_bytes(), 0};
      if (has_filters()) {
        entry.bytes = each.number(entry_bytes_ - file_.address_bytes() - 4);
        entry.mask = static_cast<uint32_t>(each.number(4));
      }
      if (entry.address == kHdf5Undefined) continue;
      if (auto visited = visit_(entry); !visited) return visited;
    }
    return {};
  }

  /// Reads pages of entries. A bit for each page states whether it exists. The bit of the first
  /// page is number `bit`; bit 0 is the highest one of the first byte.
  Result<void> take_pages(uint64_t address, std::span<const std::byte> bits, uint64_t bit,
                          uint64_t count, uint64_t per_page, uint64_t first) {
    for (uint64_t begin = 0; begin < count; begin += per_page) {
      const uint64_t page = bit + begin / per_page, entries = std::min(per_page, count - begin);
      const uint64_t bytes = entries * entry_bytes_ + 4;
      // Pages that were not written have no checksum.
      if ((bits[static_cast<size_t>(page / 8)] & std::byte(0x80 >> page % 8)) != std::byte{0}) {
        const auto content = file_.read(address, bytes);
        if (!content) return tl::unexpected(content.error());
        if (!has_hdf5_checksum(file_, *content)) return damaged();
        auto taken = take(std::span(*content).first(content->size() - 4), first + begin);
        if (!taken) return taken;
      }
      address += bytes;
    }
    return {};
  }

  Hdf5File& file_;
  const Hdf5Layout& layout_;
  const Hdf5ChunkVisitor& visit_;
  uint64_t entry_bytes_ = 0;
};

class FixedArray : ChunkArray {
 public:
  using ChunkArray::ChunkArray;

  Result<void> visit(uint64_t count) {
    const auto head =
        block_at(layout_.address, 12 + file_.length_bytes() + file_.address_bytes(), "FAHD");
    if (!head) return tl::unexpected(head.error());
    Hdf5Fields fields = file_.fields(*head);
    fields.skip(6);
    entry_bytes_ = fields.number(1);
    const uint64_t page_bits = fields.number(1);
    if (fields.length() != count || page_bits > 30 || !is_entry(entry_bytes_)) return damaged();
    const uint64_t data = fields.address();
    if (data == kHdf5Undefined) return {};
    const uint64_t prefix = 6 + file_.address_bytes(), per_page = uint64_t{1} << page_bits;
    if (count > file_.bytes() / entry_bytes_) return damaged();
    const bool has_pages = count > per_page;
    const uint64_t pages = (count + per_page - 1) / per_page;
    const uint64_t bytes = prefix + (has_pages ? (pages + 7) / 8 : count * entry_bytes_) + 4;
    const auto first = block_at(data, bytes, "FADB");
    if (!first) return tl::unexpected(first.error());
    const auto inner =
        std::span(*first).first(first->size() - 4).subspan(static_cast<size_t>(prefix));
    return has_pages ? take_pages(data + bytes, inner, 0, count, per_page, 0) : take(inner, 0);
  }
};

class GrowingArray : ChunkArray {
 public:
  using ChunkArray::ChunkArray;

  Result<void> visit() {
    const auto head =
        block_at(layout_.address, 16 + 6 * file_.length_bytes() + file_.address_bytes(), "EAHD");
    if (!head) return tl::unexpected(head.error());
    Hdf5Fields fields = file_.fields(*head);
    fields.skip(6);
    entry_bytes_ = fields.number(1);
    const uint64_t index_bits = fields.number(1), in_index = fields.number(1);
    least_entries_ = fields.number(1);
    const uint64_t least_blocks = fields.number(1), page_bits = fields.number(1);
    fields.skip(6 * file_.length_bytes());
    const uint64_t address = fields.address();
    if (!is_entry(entry_bytes_) || index_bits > 64 || page_bits > 30 ||
        !std::has_single_bit(least_entries_) || !std::has_single_bit(least_blocks) ||
        index_bits < log2_of(least_entries_) || least_blocks < 2) {
      return damaged();
    }
    if (address == kHdf5Undefined) return {};
    place_bytes_ = (index_bits + 7) / 8;
    page_entries_ = uint64_t{1} << page_bits;
    const uint64_t levels = 1 + index_bits - log2_of(least_entries_);
    const uint64_t direct_levels = std::min(levels, 2 * log2_of(least_blocks));
    const uint64_t direct_blocks = 2 * (least_blocks - 1);
    const uint64_t a = file_.address_bytes();
    const uint64_t entries = in_index * entry_bytes_;
    const auto block = block_at(
        address, 6 + a + entries + (direct_blocks + levels - direct_levels) * a + 4, "EAIB");
    if (!block) return tl::unexpected(block.error());
    fields = file_.fields(*block);
    fields.skip(6 + a);
    if (auto taken = take(fields.bytes(entries), 0); !taken) return taken;
    uint64_t first = in_index;
    for (uint64_t level = 0; level < direct_levels; ++level) {
      for (uint64_t i = 0; i < blocks_of(level); ++i, first += entries_of(level)) {
        auto taken = take_data(fields.address(), first, entries_of(level), {}, 0);
        if (!taken) return taken;
      }
    }
    for (uint64_t level = direct_levels; level < levels; ++level) {
      const uint64_t super = fields.address();
      if (super != kHdf5Undefined) {
        if (auto taken = take_super(super, first, level); !taken) return taken;
      }
      first += blocks_of(level) * entries_of(level);
    }
    return {};
  }

 private:
  static uint64_t log2_of(uint64_t power) { return static_cast<uint64_t>(std::countr_zero(power)); }
  static uint64_t blocks_of(uint64_t level) { return uint64_t{1} << level / 2; }
  uint64_t entries_of(uint64_t level) const { return least_entries_ << (level + 1) / 2; }

  Result<void> take_super(uint64_t address, uint64_t first, uint64_t level) {
    const uint64_t blocks = blocks_of(level), entries = entries_of(level);
    const uint64_t pages = entries > page_entries_ ? entries / page_entries_ : 0;
    const uint64_t bit_bytes = (pages + 7) / 8, a = file_.address_bytes();
    const uint64_t before = 6 + a + place_bytes_;
    constexpr uint64_t kMaxLevel = 56;
    if (level > kMaxLevel || blocks > file_.bytes() / a) return damaged();
    const auto super = block_at(address, before + blocks * (bit_bytes + a) + 4, "EASB");
    if (!super) return tl::unexpected(super.error());
    Hdf5Fields fields = file_.fields(*super);
    fields.skip(before);
    const auto bits = fields.bytes(blocks * bit_bytes);
    for (uint64_t i = 0; i < blocks; ++i) {
      auto taken = take_data(fields.address(), first + i * entries, entries, bits, i * pages);
      if (!taken) return taken;
    }
    return {};
  }

  /// `bits`: one for each page of its level; those of this block begin at number `bit`. Empty
  /// without pages.
  Result<void> take_data(uint64_t address, uint64_t first, uint64_t entries,
                         std::span<const std::byte> bits, uint64_t bit) {
    if (address == kHdf5Undefined) return {};
    const uint64_t before = 6 + file_.address_bytes() + place_bytes_;
    const uint64_t bytes = before + (bits.empty() ? entries * entry_bytes_ : 0) + 4;
    const auto block = block_at(address, bytes, "EADB");
    if (!block) return tl::unexpected(block.error());
    if (!bits.empty()) return take_pages(address + bytes, bits, bit, entries, page_entries_, first);
    return take(std::span(*block).first(block->size() - 4).subspan(static_cast<size_t>(before)),
                first);
  }

  uint64_t least_entries_ = 0, place_bytes_ = 0, page_entries_ = 0;
};

}  // namespace

Result<void> visit_hdf5_fixed_array(Hdf5File& file, const Hdf5Layout& layout, uint64_t count,
                                    const Hdf5ChunkVisitor& visit) {
  return FixedArray(file, layout, visit).visit(count);
}

Result<void> visit_hdf5_growing_array(Hdf5File& file, const Hdf5Layout& layout,
                                      const Hdf5ChunkVisitor& visit) {
  return GrowingArray(file, layout, visit).visit();
}

}  // namespace isosplat::import
