#include "tests/conformance/hdf5_writer.h"

// Writes HDF5 files of the oldest format, with links as messages: "HDF5 File Format Specification
// Version 3.0".
namespace isosplat::conformance {
namespace {

constexpr uint64_t kUndefined = ~uint64_t{0};

template <class T>
std::string little(T value) {
  std::string out;
  put(out, value, false);
  return out;
}

std::string padded(std::string text, size_t unit = 8) {
  text.resize((text.size() + unit - 1) / unit * unit, '\0');
  return text;
}

/// A datatype message: class and version, three bytes of flags, the size of an element in bytes,
/// and the properties of the class.
std::string type_message(int kind, uint32_t flags, uint32_t bytes, const std::string& rest) {
  std::string out(1, static_cast<char>(0x10 | kind));
  out += little(flags).substr(0, 3) + little(bytes) + rest;
  return out;
}

std::string number_type(Number kind, bool big_endian) {
  const auto bytes = static_cast<uint32_t>(bytes_of(kind));
  const std::string place = little(uint16_t{0}) + little(static_cast<uint16_t>(8 * bytes));
  const uint32_t order = big_endian ? 1 : 0;
  if (kind == Number::f32) {
    return type_message(1, order | 0x20 | 31 << 8, 4,
                        place + std::string("\x17\x08\x00\x17", 4) + little(uint32_t{127}));
  }
  if (kind == Number::f64) {
    return type_message(1, order | 0x20 | 63 << 8, 8,
                        place + std::string("\x34\x0b\x00\x34", 4) + little(uint32_t{1023}));
  }
  const bool is_signed =
      kind == Number::i8 || kind == Number::i16 || kind == Number::i32 || kind == Number::i64;
  return type_message(0, order | (is_signed ? 8 : 0), bytes, place);
}

std::string space_message(const std::vector<uint64_t>& sizes) {
  std::string out{1, static_cast<char>(sizes.size()), 0, 0, 0, 0, 0, 0};
  for (const uint64_t size : sizes) out += little(size);
  return out;
}

class Writer {
 public:
  /// Uses the addresses that the previous pass has found. All passes find the same addresses, since
  /// no size depends on an address.
  std::string write(const Hdf5Node& root) {
    out_.assign(96, '\0');
    write_node(root);
    std::string head = "\x89HDF\r\n\x1a\n";
    head += std::string{0, 0, 0, 0, 0, 8, 8, 0};
    head += little(uint16_t{4}) + little(uint16_t{16}) + little(uint32_t{0});
    head += little(uint64_t{0}) + little(kUndefined) + little(uint64_t{out_.size()}) +
            little(kUndefined);
    head += little(uint64_t{0}) + little(root.address) + std::string(24, '\0');
    out_.replace(0, head.size(), head);
    return std::move(out_);
  }

 private:
  uint64_t place(const std::string& bytes) {
    out_ = padded(std::move(out_));
    const uint64_t address = out_.size();
    out_ += bytes;
    return address;
  }

  void add_message(uint16_t kind, const std::string& content) {
    const std::string all = padded(content);
    messages_ +=
        little(kind) + little(static_cast<uint16_t>(all.size())) + std::string(4, '\0') + all;
    ++count_;
  }

  void write_node(const Hdf5Node& node) {
    for (const auto& child : node.children) write_node(*child);
    std::string layout;
    if (!node.sizes.empty()) layout = place_elements(node);
    std::vector<std::string> attributes;
    for (const auto& each : node.attributes) attributes.push_back(attribute_message(each));
    messages_.clear();
    count_ = 0;
    if (node.sizes.empty()) {
      add_message(0x02, std::string{0, 0} + little(kUndefined) + little(kUndefined));
      add_message(0x0a, std::string{0, 0});
      for (const auto& child : node.children) {
        add_message(0x06, std::string{1, 0, static_cast<char>(child->name.size())} + child->name +
                              little(child->address));
      }
    } else {
      add_message(0x01, space_message(node.sizes));
      add_message(0x03, node.type);
      add_message(0x05, std::string{2, 1, 0, 0});
      add_message(0x08, layout);
      if (node.is_compressed) {
        add_message(0x0b, std::string{1, 1, 0, 0, 0, 0, 0, 0} + little(uint16_t{1}) +
                              little(uint16_t{0}) + little(uint16_t{0}) + little(uint16_t{1}) +
                              little(uint32_t{6}) + little(uint32_t{0}));
      }
    }
    for (const std::string& each : attributes) add_message(0x0c, each);
    node.address =
        place(std::string{1, 0} + little(static_cast<uint16_t>(count_)) + little(uint32_t{1}) +
              little(static_cast<uint32_t>(messages_.size())) + std::string(4, '\0') + messages_);
  }

  std::string attribute_message(const Hdf5Node::Attribute& attribute) {
    std::string values = attribute.values;
    if (!attribute.references.empty()) {
      // A separate heap, with an object for each list.
      std::string heap;
      uint16_t index = 0;
      for (const Hdf5Node* object : attribute.references) {
        heap += little(++index) + little(uint16_t{1}) + std::string(4, '\0') + little(uint64_t{8}) +
                little(object->address);
      }
      const uint64_t bytes = 4096;
      heap += std::string(8, '\0') + little(bytes - 16 - heap.size());
      heap.resize(bytes - 16, '\0');
      const uint64_t address = place(std::string("GCOL\1\0\0\0", 8) + little(bytes) + heap);
      for (uint32_t i = 1; i <= index; ++i)
        values += little(uint32_t{1}) + little(address) + little(i);
    }
    const std::string space = space_message(attribute.sizes);
    const std::string name = attribute.name + std::string(1, '\0');
    return std::string{1, 0} + little(static_cast<uint16_t>(name.size())) +
           little(static_cast<uint16_t>(attribute.type.size())) +
           little(static_cast<uint16_t>(space.size())) + padded(name) + padded(attribute.type) +
           padded(space) + values;
  }

  std::string place_elements(const Hdf5Node& node) {
    if (node.chunk.empty()) {
      const uint64_t address = place(node.values);
      return std::string{3, 1} + little(address) + little(uint64_t{node.values.size()});
    }
    const size_t axes = node.sizes.size();
    std::string keys;
    uint16_t count = 0;
    std::vector<uint64_t> first(axes, 0);
    const auto key = [&](uint64_t bytes) {
      std::string text = little(static_cast<uint32_t>(bytes)) + little(uint32_t{0});
      for (const uint64_t at : first) text += little(at);
      return text + little(uint64_t{0});
    };
    for (bool has_more = true; has_more;) {
      std::string chunk = chunk_at(node, first);
      if (node.is_compressed) chunk = gzipped(chunk, true);
      const uint64_t address = place(chunk);
      keys += key(chunk.size()) + little(address);
      ++count;
      has_more = false;
      for (size_t axis = axes; axis-- > 0 && !has_more;) {
        first[axis] += node.chunk[axis];
        has_more = first[axis] < node.sizes[axis];
        if (!has_more) first[axis] = 0;
      }
    }
    first = node.sizes;
    std::string tree = "TREE" + std::string{1, 0} + little(count) + little(kUndefined) +
                       little(kUndefined) + keys + key(0);
    // The library reads as many bytes as a node with all its children has.
    tree.resize(24 + 65 * (8 + 8 * (axes + 1)) + 64 * 8, '\0');
    const uint64_t address = place(tree);
    std::string layout{3, 2, static_cast<char>(axes + 1)};
    layout += little(address);
    for (const uint64_t size : node.chunk) layout += little(static_cast<uint32_t>(size));
    return layout + little(static_cast<uint32_t>(node.element_bytes));
  }

  /// The elements of a chunk; those outside of the array are 0.
  static std::string chunk_at(const Hdf5Node& node, const std::vector<uint64_t>& first) {
    const size_t axes = node.sizes.size();
    uint64_t count = 1;
    for (const uint64_t size : node.chunk) count *= size;
    std::string chunk;
    for (uint64_t i = 0; i < count; ++i) {
      uint64_t rest = i, from = 0, step = 1;
      bool is_inside = true;
      for (size_t axis = axes; axis-- > 0;) {
        const uint64_t at = first[axis] + rest % node.chunk[axis];
        rest /= node.chunk[axis];
        is_inside = is_inside && at < node.sizes[axis];
        from += at * step;
        step *= node.sizes[axis];
      }
      chunk += is_inside ? node.values.substr(from * node.element_bytes, node.element_bytes)
                         : std::string(node.element_bytes, '\0');
    }
    return chunk;
  }

  std::string out_, messages_;
  size_t count_ = 0;
};

}  // namespace

Hdf5Node& Hdf5Node::at(const std::string& path) {
  const size_t slash = path.find('/');
  const std::string first = path.substr(0, slash);
  Hdf5Node* found = nullptr;
  for (const auto& child : children) {
    if (child->name == first) found = child.get();
  }
  if (!found) {
    children.push_back(std::make_unique<Hdf5Node>());
    found = children.back().get();
    found->name = first;
  }
  return slash == path.npos ? *found : found->at(path.substr(slash + 1));
}

void Hdf5Node::set_numbers(const std::string& attribute, Number kind,
                           const std::vector<double>& numbers, bool is_single) {
  attributes.push_back({attribute,
                        number_type(kind, false),
                        is_single ? std::vector<uint64_t>{} : std::vector<uint64_t>{numbers.size()},
                        binary_of(numbers, kind, false),
                        {}});
}

void Hdf5Node::set_text(const std::string& attribute, const std::string& text) {
  attributes.push_back({attribute,
                        type_message(3, 0, static_cast<uint32_t>(text.size() + 1), ""),
                        {},
                        text + '\0',
                        {}});
}

void Hdf5Node::set_references(const std::string& attribute, std::vector<const Hdf5Node*> objects) {
  const std::string lists = type_message(9, 0, 16, type_message(7, 0, 8, ""));
  const uint64_t count = objects.size();
  attributes.push_back({attribute, lists, {count}, {}, std::move(objects)});
}

void Hdf5Node::set_array(Number kind, std::vector<uint64_t> shape,
                         const std::vector<double>& numbers, bool big_endian) {
  sizes = std::move(shape);
  type = number_type(kind, big_endian);
  element_bytes = bytes_of(kind);
  values = binary_of(numbers, kind, big_endian);
}

std::string hdf5_bytes(const Hdf5Node& root) {
  // References need the addresses that the first pass finds.
  Writer().write(root);
  return Writer().write(root);
}

}  // namespace isosplat::conformance
