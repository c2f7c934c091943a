#include "shared/import/hdf5/layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/hdf5/type.h"

// The messages that describe the location of an array's elements: layout, filters, fill value.
namespace isosplat::import {
namespace {

/// Larger chunks are not decompressed in memory.
constexpr uint64_t kMaxChunkBytes = uint64_t{512} << 20;

std::string name_of_filter(uint64_t id) {
  switch (id) {
    case 4:
      return "compression with SZIP";
    case 5:
      return "compression with N-bit";
    case 6:
      return "compression with scale and offset";
    case 32001:
      return "compression with Blosc";
    case 32008:
      return "compression with bit shuffling";
    case 32015:
      return "compression with Zstandard";
    default:
      return fmt::format("the filter {}", id);
  }
}

/// u8 version, u8 filters; in version 1 6 bytes. A filter: u16 id, u16 bytes of its name (in
/// version 2 only from id 256 on), u16 flags, u16 numbers, name, u32 × numbers, in version 1 padded
/// to 8.
Result<void> take_filters(const Hdf5File& file, const Hdf5Message& message, Hdf5Layout& layout) {
  Hdf5Fields fields = file.fields(message.content);
  const uint64_t version = fields.number(1), count = fields.number(1);
  if (version != 1 && version != 2) {
    return file.unsupported(fmt::format("filters of version {}", version));
  }
  constexpr uint64_t kMaxFilters = 32;
  if (count > kMaxFilters) return file.malformed("an array has too many filters");
  if (version == 1) fields.skip(6);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t id = fields.number(2);
    const uint64_t name_bytes = version == 1 || id >= 256 ? fields.number(2) : 0;
    fields.skip(2);
    const uint64_t numbers = fields.number(2);
    fields.skip(name_bytes);
    fields.skip(4 * (numbers + (version == 1 ? numbers % 2 : 0)));
    if (fields.is_short()) return file.malformed("the filters of an array are cut off");
    const auto filter = static_cast<Hdf5Filter>(id);
    switch (filter) {
      case Hdf5Filter::deflate:
      case Hdf5Filter::shuffle:
      case Hdf5Filter::fletcher32:
      case Hdf5Filter::lzf:
      case Hdf5Filter::lz4:
        break;
      default:
        return file.unsupported(name_of_filter(id));
    }
    if (std::find(layout.filters.begin(), layout.filters.end(), filter) != layout.filters.end()) {
      return file.unsupported("the same filter twice");
    }
    layout.filters.push_back(filter);
  }
  return {};
}

/// The present message: u8 version, then by version u8 × 3 or flags; u32 bytes, the element. The
/// old one begins with the bytes.
void take_fill(const Hdf5File& file, const Hdf5Object& object, Hdf5Layout& layout) {
  for (const Hdf5Kind kind : {Hdf5Kind::old_fill_value, Hdf5Kind::fill_value}) {
    const Hdf5Message* message = object.find(kind);
    if (!message || message->is_shared) continue;
    Hdf5Fields fields = file.fields(message->content);
    if (kind == Hdf5Kind::fill_value) {
      const uint64_t version = fields.number(1);
      const uint64_t flags = version < 3 ? (fields.skip(2), fields.number(1)) : fields.number(1);
      if ((version == 2 && flags == 0) || (version == 3 && (flags & 0x20) == 0)) continue;
    }
    const uint64_t bytes = fields.number(4);
    const auto element = fields.bytes(bytes);
    if (bytes == layout.element_bytes && !fields.is_short()) {
      layout.fill.assign(element.begin(), element.end());
    }
  }
}

/// The fields after the class of chunks. Version 3: u8 axes and 1, address, u32 × (axes and 1): the
/// sizes of a chunk and the bytes of an element. Version 4: u8 flags, u8 axes and 1, u8 bytes of a
/// size, the sizes, u8 index, parameters of the index, address.
Result<void> take_chunks(const Hdf5File& file, uint64_t version, Hdf5Fields& fields,
                         Hdf5Layout& layout) {
  const uint64_t flags = version == 4 ? fields.number(1) : 0;
  const uint64_t axes = fields.number(1);
  if (version == 3) layout.address = fields.address();
  const uint64_t size_bytes = version == 4 ? fields.number(1) : 4;
  if (axes != layout.sizes.size() + 1 || size_bytes < 1 || size_bytes > 8) {
    return file.malformed("the chunks of an array do not have its axes");
  }
  for (size_t i = 0; i + 1 < axes; ++i) layout.chunk.push_back(fields.number(size_bytes));
  if (fields.number(size_bytes) != layout.element_bytes) {
    return file.malformed("the chunks of an array do not have its elements");
  }
  uint64_t bytes = layout.element_bytes;
  for (const uint64_t size : layout.chunk) {
    if (size == 0) return file.malformed("the chunks of an array have no elements");
    if (__builtin_mul_overflow(bytes, size, &bytes) || bytes > kMaxChunkBytes) {
      return file.unsupported(fmt::format("chunks of more than {} MiB", kMaxChunkBytes >> 20));
    }
  }
  layout.index = Hdf5Layout::Index::tree;
  if (version == 3) return {};
  layout.has_plain_edges = (flags & 1) != 0;
  const uint64_t index = fields.number(1);
  if (index == 1) {
    layout.index = Hdf5Layout::Index::single;
    layout.single_bytes = layout.chunk_bytes();
    if ((flags & 2) != 0) {
      layout.single_bytes = fields.length();
      layout.single_mask = static_cast<uint32_t>(fields.number(4));
    }
  } else if (index == 2) {
    layout.index = Hdf5Layout::Index::implicit;
  } else if (index == 3) {
    layout.index = Hdf5Layout::Index::fixed;
    fields.skip(1);
  } else if (index == 4) {
    layout.index = Hdf5Layout::Index::growing;
    fields.skip(5);
  } else if (index == 5) {
    layout.index = Hdf5Layout::Index::records;
    fields.skip(6);
  } else {
    return file.unsupported(fmt::format("an index of chunks of kind {}", index));
  }
  layout.address = fields.address();
  return {};
}

}  // namespace

uint64_t Hdf5Layout::chunk_bytes() const {
  uint64_t bytes = element_bytes;
  for (const uint64_t size : chunk) bytes *= size;
  return bytes;
}

Result<Hdf5Layout> read_hdf5_layout(const Hdf5File& file, const Hdf5Object& object,
                                    std::vector<uint64_t> sizes, uint64_t element_bytes) {
  Hdf5Layout layout;
  layout.sizes = std::move(sizes);
  layout.element_bytes = element_bytes;
  uint64_t bytes = element_bytes;
  for (const uint64_t size : layout.sizes) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) {
      return file.malformed("an array is larger than any file");
    }
  }
  const Hdf5Message* message = object.find(Hdf5Kind::layout);
  if (!message) return file.malformed("an array without a layout");
  if (object.find(Hdf5Kind::external_files)) return file.unsupported("elements in other files");
  Hdf5Fields fields = file.fields(message->content);
  const uint64_t version = fields.number(1), kind = fields.number(1);
  if (version != 3 && version != 4) {
    return file.unsupported(fmt::format("a layout of version {}", version));
  }
  uint64_t found = bytes;
  if (kind == 0) {  // in the message itself
    found = fields.number(2);
    layout.address = message->address + (message->content.size() - fields.left());
    fields.skip(found);
  } else if (kind == 1) {
    layout.address = fields.address();
    found = fields.length();
  } else if (kind == 2) {
    auto taken = take_chunks(file, version, fields, layout);
    if (!taken) return tl::unexpected(taken.error());
  } else if (kind == 3) {
    return file.unsupported("a virtual array, whose elements are in other files");
  } else {
    return file.malformed(fmt::format("expected a layout of kind 0 to 3, found {}", kind));
  }
  if (fields.is_short()) return file.malformed("the layout of an array is cut off");
  if (found != bytes && layout.address != kHdf5Undefined) {
    return file.malformed(fmt::format("expected {} bytes of elements, found {}", bytes, found));
  }
  if (const Hdf5Message* space = object.find(Hdf5Kind::dataspace); space && !space->is_shared) {
    layout.limits = hdf5_limits(file.fields(space->content));
  }
  if (layout.limits.size() != layout.sizes.size()) layout.limits = layout.sizes;
  using Index = Hdf5Layout::Index;
  if (layout.index != Index::none) {
    const Hdf5Message* filters = object.find(Hdf5Kind::filters);
    if (filters) {
      auto taken = take_filters(file, *filters, layout);
      if (!taken) return tl::unexpected(taken.error());
    }
    take_fill(file, object, layout);
  }
  return layout;
}

}  // namespace isosplat::import
