#include "shared/import/hdf5/object.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/hdf5/checksums.h"
#include "shared/import/hdf5/heap.h"
#include "shared/import/hdf5/records.h"

// Object headers. A header has blocks: the first one, and those that continuation messages name.
//
// version 1  u8 1, u8, u16 messages, u32 references, u32 bytes of the first block, u32
//            a message: u16 kind, u16 bytes, u8 flags, 3 bytes, content
// version 2  "OHDR", u8 2, u8 flags, times and limits by flags, bytes of the first block
//            a message: u8 kind, u16 bytes, u8 flags, u16 order by flags, content
//            u32 checksum (lookup3) after the messages; further blocks begin with "OCHK"
//
// Many attributes are in a heap, whose tree lists them by name:
//
// attribute info  u8 0, u8 flags, u16 by flags, addresses of the heap and of the tree
// a record        id in the heap, u8 flags, u32 order, u32 hash of the name
namespace isosplat::import {
namespace {

struct Block {
  uint64_t address = 0, bytes = 0;
};

constexpr uint8_t kSharedFlag = 2;
/// The header of a group or an array usually has one or two blocks.
constexpr size_t kMaxBlocks = 1024;

/// The messages of a block, without its frame. `prefix`: bytes before it in `block`.
Result<void> take_messages(const Hdf5File& file, std::span<const std::byte> bytes, uint64_t address,
                           bool is_new, bool has_order, Hdf5Object& object,
                           std::vector<Block>& blocks) {
  const size_t head = is_new ? (has_order ? 6 : 4) : 8;
  Hdf5Fields fields = file.fields(bytes);
  // Version 2 may have a gap at the end that no message fits into.
  while (fields.left() >= head) {
    const auto kind = static_cast<Hdf5Kind>(fields.number(is_new ? 1 : 2));
    const uint64_t size = fields.number(2);
    const uint64_t flags = fields.number(1);
    fields.skip(is_new ? (has_order ? 2 : 0) : 3);
    const uint64_t begin = address + (bytes.size() - fields.left());
    const auto content = fields.bytes(size);
    if (fields.is_short()) return file.malformed("a message of an object header is cut off");
    if (kind == Hdf5Kind::continuation) {
      Hdf5Fields place = file.fields(content);
      const uint64_t next = place.address(), length = place.length();
      if (place.is_short()) return file.malformed("a message of an object header is cut off");
      blocks.push_back({next, length});
      continue;
    }
    object.messages.push_back(
        {kind, (flags & kSharedFlag) != 0, begin, {content.begin(), content.end()}});
  }
  return {};
}

/// Adds the attributes that are in a heap as if they were in the header.
Result<void> take_attributes(Hdf5File& file, const Hdf5Message& info, Hdf5Object& object) {
  Hdf5Fields fields = file.fields(info.content);
  fields.skip(1);
  if ((fields.number(1) & 1) != 0) fields.skip(2);
  const uint64_t address = fields.address(), names = fields.address();
  if (fields.is_short() || address == kHdf5Undefined || names == kHdf5Undefined) return {};
  const auto heap = Hdf5Heap::open(file, address);
  if (!heap) return tl::unexpected(heap.error());
  const auto take = [&](std::span<const std::byte> record) -> Result<void> {
    auto content = heap->object(file, record.first(static_cast<size_t>(heap->id_bytes())));
    if (!content) return tl::unexpected(content.error());
    Hdf5Fields rest = file.fields(record.subspan(static_cast<size_t>(heap->id_bytes())));
    const bool is_shared = (rest.number(1) & kSharedFlag) != 0;
    if (!*content || is_shared) {
      object.has_other_attributes = true;
      return {};
    }
    object.messages.push_back({Hdf5Kind::attribute, false, 0, std::move(**content)});
    return {};
  };
  return visit_hdf5_records(file, names, Hdf5RecordKind::attribute_name, heap->id_bytes() + 9,
                            take);
}

}  // namespace

const Hdf5Message* Hdf5Object::find(Hdf5Kind kind) const {
  const auto found = std::find_if(messages.begin(), messages.end(),
                                  [&](const Hdf5Message& each) { return each.kind == kind; });
  return found == messages.end() ? nullptr : &*found;
}

Result<Hdf5Object> read_hdf5_object(Hdf5File& file, uint64_t address) {
  const auto first = file.read(address, 6);
  if (!first) return tl::unexpected(first.error());
  Hdf5Fields fields = file.fields(*first);
  const bool is_new = fields.text(4) == "OHDR";
  std::vector<Block> blocks;
  bool has_order = false;
  size_t before = 0;  // bytes of the first block before its messages
  if (is_new) {
    const uint64_t version = fields.number(1), flags = fields.number(1);
    if (version != 2) return file.unsupported(fmt::format("object headers of version {}", version));
    has_order = (flags & 4) != 0;
    const size_t size_bytes = size_t{1} << (flags & 3);
    before = 6 + ((flags & 0x20) != 0 ? 16 : 0) + ((flags & 0x10) != 0 ? 4 : 0) + size_bytes;
    const auto prefix = file.read(address, before);
    if (!prefix) return tl::unexpected(prefix.error());
    Hdf5Fields size = file.fields(std::span(*prefix).last(size_bytes));
    const uint64_t messages = size.number(size_bytes);
    if (messages > file.bytes()) return file.malformed("an object header is longer than the file");
    blocks.push_back({address, before + messages + 4});
  } else {
    const auto head = file.read(address, 16);
    if (!head) return tl::unexpected(head.error());
    fields = file.fields(*head);
    if (fields.number(1) != 1) {
      return file.malformed(fmt::format("expected an object header at {}, found none", address));
    }
    fields.skip(7);
    blocks.push_back({address + 16, fields.number(4)});
  }
  Hdf5Object object;
  // Blocks name further ones.
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (i == kMaxBlocks) return file.malformed("an object header has too many blocks");
    const Block block = blocks[i];
    const auto bytes = file.read(block.address, block.bytes);
    if (!bytes) return tl::unexpected(bytes.error());
    std::span<const std::byte> messages = *bytes;
    size_t skipped = 0;
    if (is_new) {
      skipped = i == 0 ? before : 4;
      if (messages.size() < skipped + 4) return file.malformed("an object header is cut off");
      Hdf5Fields frame = file.fields(messages);
      if (frame.text(4) != (i == 0 ? "OHDR" : "OCHK")) {
        return file.malformed(
            fmt::format("expected a part of an object header at {}, found none", block.address));
      }
      Hdf5Fields end = file.fields(messages.last(4));
      if (end.number(4) != hdf5_lookup3(messages.first(messages.size() - 4))) {
        return file.malformed("the checksum of an object header differs");
      }
      messages = messages.subspan(skipped, messages.size() - skipped - 4);
    }
    auto taken =
        take_messages(file, messages, block.address + skipped, is_new, has_order, object, blocks);
    if (!taken) return tl::unexpected(taken.error());
  }
  if (const Hdf5Message* found = object.find(Hdf5Kind::attribute_info)) {
    const Hdf5Message info = *found;
    if (auto taken = take_attributes(file, info, object); !taken) {
      return tl::unexpected(taken.error());
    }
  }
  return object;
}

}  // namespace isosplat::import
