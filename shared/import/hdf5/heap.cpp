#include "shared/import/hdf5/heap.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "shared/import/hdf5/records.h"

// Fractal heaps. Objects are stored in direct blocks; indirect blocks list these, row by row. The
// blocks of the first two rows have the same size; each further row doubles it. Rows of blocks
// larger than direct ones list further indirect blocks.
//
// header    "FRHP", u8 0, u16 bytes of an id, u16 bytes of filters, u8 flags, u32 most bytes of an
//           object, length, address, length, address, length × 8, u16 blocks in a row, length:
//           bytes of the first block, length: most bytes of a direct block, u16 bits of an offset,
//           u16, address of the root, u16 its rows (0: a direct block), u32 checksum
// direct    "FHDB", u8 0, address of the header, offset in the heap, u32 checksum by flags,
//           objects; offsets count from the signature
// indirect  "FHIB", u8 0, address of the header, offset in the heap, addresses, u32 checksum
// id        u8 kind (bits 4 and 5: 0 in a block, 1 huge, 2 in the id itself); then offset and size
namespace isosplat::import {
namespace {

constexpr int kMaxDepth = 8;
constexpr size_t kMaxBlocks = 1 << 16;

uint64_t log2_of(uint64_t power) {
  return static_cast<uint64_t>(std::countr_zero(power));
}

}  // namespace

Result<Hdf5Heap> Hdf5Heap::open(Hdf5File& file, uint64_t address) {
  const uint64_t a = file.address_bytes(), l = file.length_bytes();
  const auto head = file.read(address, 26 + 3 * a + 12 * l);
  if (!head) return tl::unexpected(head.error());
  Hdf5Fields fields = file.fields(*head);
  const auto damaged = [&] {
    return file.malformed(fmt::format("expected a heap at {}, found none", address));
  };
  if (fields.text(4) != "FRHP" || fields.number(1) != 0) return damaged();
  Hdf5Heap heap;
  heap.header_ = address;
  heap.id_bytes_ = fields.number(2);
  const uint64_t filters = fields.number(2);
  fields.skip(1);
  const uint64_t most_bytes = fields.number(4);
  fields.skip(10 * l + 2 * a);
  heap.width_ = fields.number(2);
  heap.first_block_bytes_ = fields.length();
  heap.most_block_bytes_ = fields.length();
  const uint64_t offset_bits = fields.number(2);
  fields.skip(2);
  const uint64_t root = fields.address(), rows = fields.number(2);
  if (filters > 0) return file.unsupported("a compressed heap of links or attributes");
  if (!has_hdf5_checksum(file, *head)) return damaged();
  const auto is_size = [](uint64_t bytes) {
    return std::has_single_bit(bytes) && bytes <= 1 << 30;
  };
  if (!is_size(heap.first_block_bytes_) || !is_size(heap.most_block_bytes_) ||
      !std::has_single_bit(heap.width_) || heap.first_block_bytes_ > heap.most_block_bytes_ ||
      offset_bits > 64) {
    return damaged();
  }
  heap.offset_bytes_ = (offset_bits + 7) / 8;
  heap.size_bytes_ = std::min((log2_of(heap.most_block_bytes_) + 7) / 8,
                              (static_cast<uint64_t>(std::bit_width(most_bytes)) + 7) / 8);
  if (root == kHdf5Undefined) return heap;
  if (rows == 0) {
    heap.blocks_.push_back({0, heap.first_block_bytes_, root});
    return heap;
  }
  if (auto read = heap.read_blocks(file, root, 0, rows, 0); !read)
    return tl::unexpected(read.error());
  return heap;
}

uint64_t Hdf5Heap::row_block_bytes(uint64_t row) const {
  return row < 2 ? first_block_bytes_ : first_block_bytes_ << (row - 1);
}

Result<void> Hdf5Heap::read_blocks(Hdf5File& file, uint64_t address, uint64_t offset, uint64_t rows,
                                   int depth) {
  const uint64_t direct_rows = log2_of(most_block_bytes_ / first_block_bytes_) + 2;
  const auto damaged = [&] {
    return file.malformed(fmt::format("expected a block of a heap at {}, found none", address));
  };
  if (depth > kMaxDepth || rows > 40) return damaged();
  const uint64_t before = 5 + file.address_bytes() + offset_bytes_;
  const auto block = file.read(address, before + rows * width_ * file.address_bytes() + 4);
  if (!block) return tl::unexpected(block.error());
  Hdf5Fields fields = file.fields(*block);
  if (fields.text(4) != "FHIB" || fields.number(1) != 0 || fields.address() != header_ ||
      fields.number(offset_bytes_) != offset || !has_hdf5_checksum(file, *block)) {
    return damaged();
  }
  for (uint64_t row = 0; row < rows; ++row) {
    const uint64_t bytes = row_block_bytes(row);
    for (uint64_t i = 0; i < width_; ++i, offset += bytes) {
      const uint64_t child = fields.address();
      if (child == kHdf5Undefined) continue;
      if (blocks_.size() == kMaxBlocks) return file.unsupported("more objects than can be listed");
      if (row < direct_rows) {
        blocks_.push_back({offset, bytes, child});
        continue;
      }
      // The rows of the indirect block contain as many bytes as the block takes in its parent.
      const uint64_t inner = log2_of(bytes / first_block_bytes_ / width_) + 1;
      if (auto read = read_blocks(file, child, offset, inner, depth + 1); !read) return read;
    }
  }
  return {};
}

Result<std::optional<std::vector<std::byte>>> Hdf5Heap::object(
    Hdf5File& file, std::span<const std::byte> id) const {
  enum Kind : uint64_t { in_block = 0, huge = 1, in_id = 2 };
  const auto damaged = [&] { return file.malformed("a heap does not have an object"); };
  Hdf5Fields fields = file.fields(id);
  const uint64_t first = fields.number(1), kind = first >> 4 & 3;
  if (kind == huge) return std::nullopt;
  if (kind == in_id) {
    const bool is_long = id.size() > 18;
    const uint64_t size = (is_long ? (first & 15) << 8 | fields.number(1) : first & 15) + 1;
    const auto content = fields.bytes(size);
    if (fields.is_short()) return damaged();
    return std::vector<std::byte>(content.begin(), content.end());
  }
  const uint64_t offset = fields.number(offset_bytes_), size = fields.number(size_bytes_);
  if (kind != in_block || fields.is_short()) return damaged();
  auto block =
      std::upper_bound(blocks_.begin(), blocks_.end(), offset,
                       [](uint64_t sought, const Block& each) { return sought < each.offset; });
  if (block == blocks_.begin()) return damaged();
  --block;
  const uint64_t inside = offset - block->offset;
  if (inside > block->bytes || size > block->bytes - inside) return damaged();
  auto content = file.read(block->address + inside, size);
  if (!content) return tl::unexpected(content.error());
  return std::move(*content);
}

}  // namespace isosplat::import
