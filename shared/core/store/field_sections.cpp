#include "shared/core/store/field_sections.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "shared/core/store/format.h"
#include "shared/core/store/header_sections.h"

namespace isosplat {
namespace {

/// Whether it begins with a letter, and has letters, digits, '_', '-' and '.' only: names are parts
/// of addresses, and of files of other formats.
bool is_name(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && text.size() <= kMaxFieldNameBytes && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(), [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
         });
}

/// Why a field is not valid; empty if it is.
std::string fault_of(const FieldInfo& field) {
  if (!is_name(field.name)) {
    return "expected a name of at most 64 letters, digits, '_', '-' and '.' that begins with a "
           "letter";
  }
  const ValueMapping& mapping = field.mapping;
  if (!std::isfinite(mapping.offset) || !std::isfinite(mapping.scale) ||
      !std::isfinite(mapping.max_error) || !(mapping.scale > 0) || mapping.max_error < 0) {
    return "its offset, scale or error bound is outside the limits";
  }
  if ((mapping.bits != 8 && mapping.bits != 16) || (mapping.bits == 8 && mapping.has_missing)) {
    return "its bits or flags are outside the limits";
  }
  if (field.range.min > field.range.max || (mapping.bits == 8 && field.range.max > 255)) {
    return "its range is outside the limits";
  }
  if (field.missing_voxels > 0 && !mapping.has_missing) return "its missing voxels are not marked";
  return {};
}

size_t record_bytes(const FieldInfo& field) {
  return padded_to_8(kFieldRecordBytes + field.name.size());
}

size_t list_bytes(const StoreInfo& info) {
  size_t bytes = kFieldListHeaderBytes;
  for (const FieldRef& field : info.fields) bytes += 8 + record_bytes(field.info);
  return bytes;
}

void write_record(const FieldInfo& field, FieldWriter& to) {
  for (const double v : {field.mapping.offset, field.mapping.scale, field.mapping.max_error}) {
    to.f64(v);
  }
  to.field(8, field.missing_voxels);
  to.field(2, field.range.min);
  to.field(2, field.range.max);
  to.field(1, field.mapping.bits);
  to.field(1, field.mapping.has_missing ? 1 : 0);
  to.field(1, field.name.size());
  to.field(1, 0);
  for (const char c : field.name) to.field(1, static_cast<uint8_t>(c));
  const size_t bytes = kFieldRecordBytes + field.name.size();
  for (size_t i = bytes; i < padded_to_8(bytes); ++i) to.field(1, 0);
}

/// Reads a record from the beginning of `bytes`, and removes it from them.
Result<FieldInfo> read_record(std::span<const std::byte>& bytes) {
  if (bytes.size() < kFieldRecordBytes) return malformed_header("a field's record is truncated");
  FieldReader at(bytes.data());
  FieldInfo field;
  field.mapping.offset = at.f64();
  field.mapping.scale = at.f64();
  field.mapping.max_error = at.f64();
  field.missing_voxels = at.u64();
  field.range = {at.u16(), at.u16()};
  field.mapping.bits = at.u8();
  const uint8_t flags = at.u8();
  field.mapping.has_missing = (flags & 1) != 0;
  const size_t name_bytes = at.u8();
  const size_t end = kFieldRecordBytes + name_bytes;
  if (flags > 1 || bytes.size() < padded_to_8(end)) {
    return malformed_header("a field's flags are unknown, or its record is truncated");
  }
  field.name.assign(reinterpret_cast<const char*>(bytes.data() + kFieldRecordBytes), name_bytes);
  if (const std::string fault = fault_of(field); !fault.empty()) {
    return malformed_header("a field: " + fault);
  }
  bytes = bytes.subspan(padded_to_8(end));
  return field;
}

}  // namespace

Result<void> check_field(const FieldInfo& field) {
  if (const std::string fault = fault_of(field); !fault.empty()) {
    return fail(Status::invalid_argument, "field '" + field.name + "': " + fault);
  }
  return {};
}

size_t field_sections_bytes(const StoreInfo& info) {
  size_t bytes = info.fields.empty() ? 0 : kSectionHeaderBytes + list_bytes(info);
  if (info.field) bytes += kSectionHeaderBytes + record_bytes(*info.field);
  return bytes;
}

Result<void> parse_field_list(std::span<const std::byte> payload, StoreInfo& info) {
  if (payload.size() < kFieldListHeaderBytes) return malformed_header("section flds is truncated");
  const auto count = static_cast<uint32_t>(read_le(payload.data(), 4));
  if (count < 1 || count > kMaxFields) {
    return malformed_header("fields: expected 1 to " + std::to_string(kMaxFields) + ", found " +
                            std::to_string(count));
  }
  payload = payload.subspan(kFieldListHeaderBytes);
  uint64_t offset = info.header_bytes;
  std::set<std::string> names;
  for (uint32_t i = 0; i < count; ++i) {
    if (payload.size() < 8) return malformed_header("section flds is truncated");
    const uint64_t bytes = read_le(payload.data(), 8);
    if (bytes > info.file_bytes - offset) {
      return malformed_header("field " + std::to_string(i) + " ends beyond the file, by its " +
                              std::to_string(bytes) + " bytes");
    }
    payload = payload.subspan(8);
    auto record = read_record(payload);
    if (!record) return tl::unexpected(record.error());
    if (!names.insert(record->name).second) {
      return malformed_header("two fields have the name '" + record->name + "'");
    }
    info.fields.push_back({std::move(*record), offset, bytes});
    offset += bytes;
  }
  if (!payload.empty()) return malformed_header("section flds has bytes after its fields");
  return {};
}

Result<void> parse_own_field(std::span<const std::byte> payload, StoreInfo& info) {
  auto record = read_record(payload);
  if (!record) return tl::unexpected(record.error());
  if (!payload.empty()) return malformed_header("section FIEL has bytes after its record");
  info.field = std::move(*record);
  return {};
}

void write_field_sections(const StoreInfo& info, FieldWriter& to) {
  if (!info.fields.empty()) {
    to.field(4, kFieldListTag);
    to.field(4, list_bytes(info));
    to.field(4, info.fields.size());
    to.field(4, 0);
    for (const FieldRef& field : info.fields) {
      to.field(8, field.bytes);
      write_record(field.info, to);
    }
  }
  if (info.field) {
    to.field(4, kOwnFieldTag);
    to.field(4, record_bytes(*info.field));
    write_record(*info.field, to);
  }
}

}  // namespace isosplat
