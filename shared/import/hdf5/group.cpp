#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "shared/import/hdf5/heap.h"
#include "shared/import/hdf5/object.h"
#include "shared/import/hdf5/records.h"
#include "shared/import/hdf5/tree.h"

// The links of groups. A group is a symbol table, or has a message for each link; many such
// messages are in a heap, whose tree lists them by name (a record: u32 hash of the name, id in the
// heap).
//
// symbol table   address of a B-tree of version 1, address of a local heap with the names
// a tree's node  (tree.h)
//                (length: a name, address: a node of the level below, or "SNOD") × entries, length
// its leaf       "SNOD", u8 1, u8, u16 entries
//                address of the name in the heap, address of the object header, u32 kind, 20 bytes
// local heap     "HEAP", u8 0, 3 bytes, length: bytes of its data, length, address: its data
namespace isosplat::import {
namespace {

using Links = std::vector<Hdf5Link>;

/// Maximum number of links to list. Only hostile files exceed it.
constexpr size_t kMaxLinks = 100'000;
constexpr uint64_t kMaxHeapBytes = uint64_t{64} << 20;

Result<void> take_symbols(Hdf5File& file, uint64_t address, std::span<const std::byte> names,
                          Links& links) {
  const auto head = file.read(address, 8);
  if (!head) return tl::unexpected(head.error());
  Hdf5Fields fields = file.fields(*head);
  if (fields.text(4) != "SNOD") {
    return file.malformed(
        fmt::format("expected the symbols of a group at {}, found none", address));
  }
  fields.skip(2);
  const uint64_t count = fields.number(2);
  const uint64_t bytes = file.length_bytes() + file.address_bytes() + 24;
  const auto entries = file.read(address + 8, count * bytes);
  if (!entries) return tl::unexpected(entries.error());
  fields = file.fields(*entries);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t name = fields.length(), object = fields.address();
    constexpr uint64_t kSymbolicLink = 2;
    const uint64_t kind = fields.number(4);
    fields.skip(20);
    if (kind == kSymbolicLink || object == kHdf5Undefined) continue;
    if (name >= names.size()) return file.malformed("the name of a link is outside of its heap");
    const auto from = names.subspan(static_cast<size_t>(name));
    const auto end = std::find(from.begin(), from.end(), std::byte{0});
    if (end == from.end()) return file.malformed("the name of a link has no end");
    if (links.size() == kMaxLinks) return file.unsupported("more objects than can be listed");
    links.push_back(
        {{reinterpret_cast<const char*>(from.data()), static_cast<size_t>(end - from.begin())},
         object});
  }
  return {};
}

/// `level`: the required level of the node; any level for the root.
Result<void> take_tree(Hdf5File& file, uint64_t address, std::optional<uint64_t> level,
                       std::span<const std::byte> names, Links& links) {
  const auto node = read_hdf5_tree_node(file, address, Hdf5TreeKind::group, level);
  if (!node) return tl::unexpected(node.error());
  const uint64_t entry_bytes = file.length_bytes() + file.address_bytes();
  const auto entries = file.read(node->entries, node->count * entry_bytes);
  if (!entries) return tl::unexpected(entries.error());
  Hdf5Fields fields = file.fields(*entries);
  for (uint64_t i = 0; i < node->count; ++i) {
    fields.length();
    const uint64_t child = fields.address();
    auto taken = node->level == 0 ? take_symbols(file, child, names, links)
                                  : take_tree(file, child, node->level - 1, names, links);
    if (!taken) return taken;
  }
  return {};
}

Result<void> take_symbol_table(Hdf5File& file, const Hdf5Message& message, Links& links) {
  Hdf5Fields fields = file.fields(message.content);
  const uint64_t tree = fields.address(), heap = fields.address();
  if (fields.is_short()) return file.malformed("a symbol table is cut off");
  const auto head = file.read(heap, 8 + 2 * file.length_bytes() + file.address_bytes());
  if (!head) return tl::unexpected(head.error());
  fields = file.fields(*head);
  if (fields.text(4) != "HEAP") {
    return file.malformed(fmt::format("expected the names of a group at {}, found none", heap));
  }
  fields.skip(4);
  const uint64_t bytes = fields.length();
  fields.length();
  const uint64_t data = fields.address();
  if (bytes > kMaxHeapBytes) return file.unsupported("a group with more names than can be listed");
  const auto names = file.read(data, bytes);
  if (!names) return tl::unexpected(names.error());
  return take_tree(file, tree, std::nullopt, *names, links);
}

/// u8 1, u8 flags, u8 kind, u64 order, u8 character set: these three by flags; bytes of the name,
/// the name, of a hard link an address.
Result<void> take_link(const Hdf5File& file, std::span<const std::byte> message, Links& links) {
  Hdf5Fields fields = file.fields(message);
  const uint64_t version = fields.number(1), flags = fields.number(1);
  const uint64_t kind = (flags & 8) != 0 ? fields.number(1) : 0;
  if ((flags & 4) != 0) fields.skip(8);
  if ((flags & 16) != 0) fields.skip(1);
  const std::string name(fields.text(fields.number(size_t{1} << (flags & 3))));
  if (version != 1) return file.unsupported(fmt::format("links of version {}", version));
  if (kind != 0) return {};
  const uint64_t address = fields.address();
  if (fields.is_short()) return file.malformed("a link is cut off");
  if (links.size() == kMaxLinks) return file.unsupported("more objects than can be listed");
  links.push_back({name, address});
  return {};
}

/// u8 0, u8 flags, u64 by flags, addresses of the heap and of the tree.
Result<void> take_heap(Hdf5File& file, const Hdf5Message& message, Links& links) {
  Hdf5Fields fields = file.fields(message.content);
  fields.skip(1);
  if ((fields.number(1) & 1) != 0) fields.skip(8);
  const uint64_t address = fields.address(), names = fields.address();
  if (fields.is_short() || address == kHdf5Undefined || names == kHdf5Undefined) return {};
  const auto heap = Hdf5Heap::open(file, address);
  if (!heap) return tl::unexpected(heap.error());
  const auto take = [&](std::span<const std::byte> record) -> Result<void> {
    const auto link = heap->object(file, record.subspan(4));
    if (!link) return tl::unexpected(link.error());
    if (!*link) return file.unsupported("a link with a name of more than a block");
    return take_link(file, **link, links);
  };
  return visit_hdf5_records(file, names, Hdf5RecordKind::link_name, 4 + heap->id_bytes(), take);
}

}  // namespace

Result<Links> hdf5_links(Hdf5File& file, const Hdf5Object& group) {
  Links links;
  for (const Hdf5Message& message : group.messages) {
    Result<void> taken;
    if (message.kind == Hdf5Kind::symbol_table) taken = take_symbol_table(file, message, links);
    if (message.kind == Hdf5Kind::link) taken = take_link(file, message.content, links);
    if (message.kind == Hdf5Kind::link_info) taken = take_heap(file, message, links);
    if (!taken) return tl::unexpected(taken.error());
  }
  return links;
}

}  // namespace isosplat::import
