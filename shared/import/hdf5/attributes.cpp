#include "shared/import/hdf5/attributes.h"

#include <algorithm>
#include <cstring>

// An attribute: u8 version, u8 flags, u16 bytes of its name, of its type, of its dataspace, u8
// character set (version 3); name, type and dataspace (in version 1 each padded to 8 bytes);
// values.
namespace isosplat::import {
namespace {

constexpr uint64_t kMaxElements = 1024;
constexpr uint64_t kMaxTextBytes = 64 * 1024;

struct Attribute {
  std::string_view name;
  Hdf5Type type;
  uint64_t count = 1;
  std::span<const std::byte> values;
};

std::optional<Attribute> parse(const Hdf5File& file, const Hdf5Message& message) {
  Hdf5Fields fields = file.fields(message.content);
  const uint64_t version = fields.number(1), flags = fields.number(1);
  const uint64_t name_bytes = fields.number(2), type_bytes = fields.number(2),
                 space_bytes = fields.number(2);
  if (version == 3) fields.skip(1);
  // Bits 0 and 1: the type or the dataspace is stored elsewhere.
  if (version < 1 || version > 3 || (version > 1 && (flags & 3) != 0)) return std::nullopt;
  const auto part = [&](uint64_t bytes) {
    const auto taken = fields.bytes(bytes);
    if (version == 1) fields.skip((8 - bytes % 8) % 8);
    return taken;
  };
  const auto name = part(name_bytes), type = part(type_bytes), space = part(space_bytes);
  Attribute attribute;
  attribute.name = {reinterpret_cast<const char*>(name.data()), name.size()};
  attribute.name = attribute.name.substr(0, attribute.name.find('\0'));
  const auto parsed = hdf5_type(file.fields(type));
  const auto sizes = hdf5_sizes(file.fields(space));
  if (fields.is_short() || !parsed || !sizes) return std::nullopt;
  attribute.type = *parsed;
  for (const uint64_t size : *sizes) {
    if (size > kMaxElements) return std::nullopt;
    attribute.count *= size;
    if (attribute.count > kMaxElements) return std::nullopt;
  }
  if (parsed->bytes > fields.left()) return std::nullopt;
  attribute.values = fields.bytes(attribute.count * parsed->bytes);
  if (fields.is_short()) return std::nullopt;
  return attribute;
}

std::optional<Attribute> find(const Hdf5File& file, const Hdf5Object& object,
                              std::string_view name) {
  for (const Hdf5Message& message : object.messages) {
    if (message.kind != Hdf5Kind::attribute || message.is_shared) continue;
    auto attribute = parse(file, message);
    if (attribute && attribute->name == name) return attribute;
  }
  return std::nullopt;
}

/// Reads an object of a global heap, of at least these bytes: "GCOL", u8 1, 3 bytes, length: bytes
/// of the heap; then objects: u16 index, u16, 4 bytes, length, content, padding to 8 bytes.
std::optional<std::vector<std::byte>> heap_object(Hdf5File& file, uint64_t address, uint64_t index,
                                                  uint64_t bytes) {
  const auto head = file.read(address, 8 + file.length_bytes());
  if (!head) return std::nullopt;
  Hdf5Fields fields = file.fields(*head);
  if (fields.text(4) != "GCOL") return std::nullopt;
  fields.skip(4);
  const uint64_t heap_bytes = fields.length();
  constexpr uint64_t kMaxHeapBytes = uint64_t{16} << 20;
  if (heap_bytes < head->size() || heap_bytes > kMaxHeapBytes) return std::nullopt;
  const auto heap = file.read(address, heap_bytes);
  if (!heap) return std::nullopt;
  fields = file.fields(*heap);
  fields.skip(head->size());
  while (fields.left() > 8 + file.length_bytes()) {
    const uint64_t found = fields.number(2);
    fields.skip(6);
    const uint64_t size = fields.length();
    if (found == 0) break;  // free space
    const auto content = fields.bytes(size);
    fields.skip(std::min<uint64_t>((8 - size % 8) % 8, fields.left()));
    if (found == index && bytes <= content.size()) {
      return std::vector(content.begin(), content.begin() + static_cast<std::ptrdiff_t>(bytes));
    }
  }
  return std::nullopt;
}

/// The data of an element of variable size: u32 count, address of a global heap, u32 index in it.
std::optional<std::vector<std::byte>> variable_element(Hdf5File& file, Hdf5Fields& values,
                                                       uint64_t each_bytes) {
  const uint64_t count = values.number(4), heap = values.address(), index = values.number(4);
  if (values.is_short() || count > kMaxTextBytes) return std::nullopt;
  if (count == 0) return std::vector<std::byte>();
  return heap_object(file, heap, index, count * each_bytes);
}

}  // namespace

std::optional<std::vector<double>> hdf5_numbers(const Hdf5File& file, const Hdf5Object& object,
                                                std::string_view name) {
  const auto attribute = find(file, object, name);
  if (!attribute || attribute->type.kind != Hdf5Type::Kind::number) return std::nullopt;
  const auto bytes = static_cast<size_t>(attribute->type.bytes);
  std::vector<double> numbers;
  for (size_t i = 0; i < attribute->count; ++i) {
    numbers.push_back(
        stored_number(attribute->type.stored, attribute->values.subspan(i * bytes, bytes)));
  }
  return numbers;
}

std::optional<std::vector<std::string>> hdf5_texts(Hdf5File& file, const Hdf5Object& object,
                                                   std::string_view name) {
  const auto attribute = find(file, object, name);
  if (!attribute) return std::nullopt;
  Hdf5Fields values = file.fields(attribute->values);
  std::vector<std::string> texts;
  for (uint64_t i = 0; i < attribute->count; ++i) {
    std::string text;
    if (attribute->type.kind == Hdf5Type::Kind::text) {
      text = values.text(attribute->type.bytes);
    } else if (attribute->type.kind == Hdf5Type::Kind::variable_text) {
      const auto found = variable_element(file, values, 1);
      if (!found) return std::nullopt;
      text.assign(reinterpret_cast<const char*>(found->data()), found->size());
    } else {
      return std::nullopt;
    }
    text.resize(std::min(text.find('\0'), text.size()));
    while (text.ends_with(' ')) text.pop_back();
    texts.push_back(std::move(text));
  }
  return texts;
}

std::string hdf5_text(Hdf5File& file, const Hdf5Object& object, std::string_view name) {
  std::string joined;
  for (const std::string& text :
       hdf5_texts(file, object, name).value_or(std::vector<std::string>())) {
    joined += text;
  }
  return joined;
}

std::optional<std::vector<std::vector<uint64_t>>> hdf5_references(Hdf5File& file,
                                                                  const Hdf5Object& object,
                                                                  std::string_view name) {
  const auto attribute = find(file, object, name);
  if (!attribute || attribute->type.kind != Hdf5Type::Kind::reference_list) return std::nullopt;
  Hdf5Fields values = file.fields(attribute->values);
  std::vector<std::vector<uint64_t>> lists;
  for (uint64_t i = 0; i < attribute->count; ++i) {
    const auto content = variable_element(file, values, file.address_bytes());
    if (!content) return std::nullopt;
    Hdf5Fields addresses = file.fields(*content);
    lists.emplace_back();
    while (addresses.left() > 0) lists.back().push_back(addresses.address());
  }
  return lists;
}

std::optional<VoxelType> hdf5_number_type(const Hdf5File& file, const Hdf5Object& object,
                                          std::string_view name) {
  const auto attribute = find(file, object, name);
  if (!attribute || attribute->type.kind != Hdf5Type::Kind::number) return std::nullopt;
  return attribute->type.stored.type;
}

}  // namespace isosplat::import
