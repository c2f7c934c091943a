#include "shared/import/hdf5/type.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace isosplat::import {
namespace {

constexpr size_t kMaxAxes = 32;  // the limit of HDF5

enum class Class : uint8_t {
  integer,
  real,
  time,
  text,
  bits,
  opaque,
  record,
  reference,
  enumeration,
  variable,
  array
};

constexpr const char* kClassNames[] = {"integers",       "floating-point numbers",
                                       "times",          "texts",
                                       "bit fields",     "opaque bytes",
                                       "records",        "references",
                                       "an enumeration", "sequences",
                                       "arrays"};

/// The type of integers that use all bits of their bytes.
std::optional<VoxelType> integer_type(uint64_t bytes, bool is_signed) {
  constexpr std::array kUnsigned{VoxelType::u8, VoxelType::u16, VoxelType::u32, VoxelType::u64};
  constexpr std::array kSigned{VoxelType::i8, VoxelType::i16, VoxelType::i32, VoxelType::i64};
  for (size_t i = 0; i < 4; ++i) {
    if (bytes == uint64_t{1} << i) return is_signed ? kSigned[i] : kUnsigned[i];
  }
  return std::nullopt;
}

/// Reads the properties of an integer type: u16 offset, u16 precision.
Hdf5Type integer(Hdf5Fields fields, uint64_t flags, uint64_t bytes) {
  Hdf5Type type;
  type.bytes = bytes;
  const uint64_t offset = fields.number(2), precision = fields.number(2);
  const auto known = integer_type(bytes, (flags & 8) != 0);
  if (!known || offset != 0 || precision != 8 * bytes) {
    type.name = fmt::format("integers of {} bits in {} bytes", precision, bytes);
    return type;
  }
  type.kind = Hdf5Type::Kind::number;
  type.stored.type = *known;
  type.stored.big_endian = (flags & 1) != 0;
  return type;
}

/// Reads the properties of a floating-point type: u16 offset, u16 precision; as u8, the position
/// and the number of bits of the exponent, and those of the fraction; u32 bias.
Hdf5Type real(Hdf5Fields fields, uint64_t flags, uint64_t bytes) {
  struct Ieee {
    uint64_t bytes, exponent_bits, fraction_bits, bias;
  };
  Hdf5Type type;
  type.bytes = bytes;
  std::array<uint64_t, 6> found{};
  for (size_t i = 0; i < 6; ++i) found[i] = fields.number(i < 2 ? 2 : 1);
  const uint64_t bias = fields.number(4);
  const uint64_t sign = flags >> 8 & 0xff, order = flags & 0x41, normalization = flags >> 4 & 3;
  for (const Ieee& known : {Ieee{2, 5, 10, 15}, Ieee{4, 8, 23, 127}, Ieee{8, 11, 52, 1023}}) {
    const std::array<uint64_t, 6> expected{
        0, 8 * bytes, known.fraction_bits, known.exponent_bits, 0, known.fraction_bits};
    if (known.bytes != bytes || found != expected || bias != known.bias || sign != 8 * bytes - 1 ||
        order > 1 || normalization != 2) {
      continue;
    }
    type.kind = Hdf5Type::Kind::number;
    type.stored.type = bytes == 8 ? VoxelType::f64 : VoxelType::f32;
    type.stored.is_half = bytes == 2;
    type.stored.big_endian = order == 1;
    return type;
  }
  type.name = fmt::format("floating-point numbers of {} bits in {} bytes", found[1], bytes);
  return type;
}

std::optional<Hdf5Type> type_of(Hdf5Fields fields, int depth) {
  const uint64_t head = fields.number(1), flags = fields.number(3), bytes = fields.number(4);
  if (fields.is_short() || bytes == 0) return std::nullopt;
  const auto kind = static_cast<Class>(head & 15);
  Hdf5Type type;
  if (kind == Class::integer) {
    type = integer(fields, flags, bytes);
  } else if (kind == Class::real) {
    type = real(fields, flags, bytes);
  } else if (kind == Class::enumeration && depth == 0) {
    // Its values have the type that follows: h5py's booleans are an enumeration of bytes.
    const auto base = type_of(fields, depth + 1);
    if (!base) return std::nullopt;
    type = *base;
    if (type.bytes != bytes) return std::nullopt;
  } else {
    if (kind == Class::text) type.kind = Hdf5Type::Kind::text;
    if (kind == Class::variable && (flags & 15) == 1) type.kind = Hdf5Type::Kind::variable_text;
    if (kind == Class::variable && (flags & 15) == 0) {
      // Of the following types, only references to objects are supported.
      const uint64_t base = fields.number(1) & 15, base_flags = fields.number(3);
      const bool is_object =
          base == static_cast<uint64_t>(Class::reference) && (base_flags & 15) == 0;
      if (is_object) type.kind = Hdf5Type::Kind::reference_list;
    }
    const auto index = static_cast<size_t>(kind);
    type.name = index < std::size(kClassNames) ? kClassNames[index] : "an unknown type";
  }
  type.bytes = bytes;
  return type;
}

}  // namespace

std::optional<Hdf5Type> hdf5_type(Hdf5Fields fields) {
  return type_of(fields, 0);
}

std::optional<std::vector<uint64_t>> hdf5_sizes(Hdf5Fields fields) {
  const uint64_t version = fields.number(1), axes = fields.number(1);
  fields.skip(1);
  // Version 1 has 5 reserved bytes. Version 2 has the kind of the dataspace; kind 2 has no
  // elements.
  const uint64_t kind = version == 1 ? (fields.skip(5), 0) : fields.number(1);
  if (version < 1 || version > 2 || kind > 1 || axes > kMaxAxes) return std::nullopt;
  std::vector<uint64_t> sizes;
  for (uint64_t i = 0; i < axes; ++i) sizes.push_back(fields.length());
  if (fields.is_short()) return std::nullopt;
  return sizes;
}

std::vector<uint64_t> hdf5_limits(Hdf5Fields fields) {
  const uint64_t version = fields.number(1), axes = fields.number(1), flags = fields.number(1);
  fields.skip(version == 1 ? 5 : 1);
  std::vector<uint64_t> sizes, limits;
  for (uint64_t i = 0; i < axes; ++i) sizes.push_back(fields.length());
  if ((flags & 1) == 0) return sizes;
  // A length with all bits set means no limit.
  for (uint64_t i = 0; i < axes; ++i) limits.push_back(fields.unlimited_length());
  return limits;
}

Result<Hdf5Message> hdf5_message(Hdf5File& file, const Hdf5Object& object, Hdf5Kind kind) {
  const Hdf5Message* message = object.find(kind);
  if (!message) return file.malformed("an array without a description of its elements");
  if (!message->is_shared) return *message;
  // u8 version, u8 kind, 6 reserved bytes in version 1, address of the object that has the message
  Hdf5Fields fields = file.fields(message->content);
  const uint64_t version = fields.number(1), where = fields.number(1);
  if (version == 1) fields.skip(6);
  constexpr uint64_t kInHeap = 1;
  if (version == 3 && where == kInHeap) return file.unsupported("a message in a shared heap");
  const auto other = read_hdf5_object(file, fields.address());
  if (!other) return tl::unexpected(other.error());
  message = other->find(kind);
  if (!message || message->is_shared) return file.malformed("a named type that does not exist");
  return *message;
}

Result<Hdf5Elements> hdf5_elements(Hdf5File& file, const Hdf5Object& dataset) {
  const auto space = hdf5_message(file, dataset, Hdf5Kind::dataspace);
  if (!space) return tl::unexpected(space.error());
  const auto type = hdf5_message(file, dataset, Hdf5Kind::datatype);
  if (!type) return tl::unexpected(type.error());
  return Hdf5Elements{hdf5_sizes(file.fields(space->content)),
                      hdf5_type(file.fields(type->content))};
}

}  // namespace isosplat::import
