#include "server/routes/point_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace isosplat::server {

static_assert(std::endian::native == std::endian::little, "records have the layout of memory");

namespace {

constexpr std::string_view kNames[] = {"positions", "normals", "values"};

std::string_view name_of(PointField field) {
  return kNames[static_cast<size_t>(field)];
}

void put(std::byte*& at, const auto& value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

}  // namespace

Result<PointRecords> PointRecords::parse(std::string_view fields, bool double_positions) {
  PointRecords records;
  records.doubles_ = double_positions;
  while (true) {
    const std::string_view name = fields.substr(0, fields.find(','));
    const auto* const found = std::ranges::find(kNames, name);
    const auto field = static_cast<PointField>(found - std::begin(kNames));
    if (found == std::end(kNames) || records.has(field)) {
      return fail(Status::invalid_argument,
                  "expected some of positions, normals and values, separated by commas, each once");
    }
    records.fields_.push_back(field);
    if (name.size() == fields.size()) return records;
    fields.remove_prefix(name.size() + 1);
  }
}

void PointRecords::add_field(const std::string& name) {
  field_of_store_ = std::ranges::find(kNames, name) == std::end(kNames) ? name : name + "_field";
}

bool PointRecords::has(PointField field) const {
  return std::ranges::find(fields_, field) != fields_.end();
}

size_t PointRecords::bytes() const {
  size_t bytes = field_of_store_.empty() ? 0 : 4;
  for (const PointField field : fields_) {
    if (field == PointField::positions) bytes += doubles_ ? 24 : 12;
    if (field == PointField::normals) bytes += 12;
    if (field == PointField::values) bytes += 4;
  }
  return bytes;
}

std::string PointRecords::dtype() const {
  std::string list;
  for (const PointField field : fields_) {
    if (!list.empty()) list += ", ";
    const bool is_double = field == PointField::positions && doubles_;
    list += fmt::format("('{}', '{}'{})", name_of(field), is_double ? "<f8" : "<f4",
                        field == PointField::values ? "" : ", (3,)");
  }
  if (!field_of_store_.empty()) list += fmt::format(", ('{}', '<f4')", field_of_store_);
  return "[" + list + "]";
}

std::string PointRecords::npy_header(uint64_t count) const {
  const bool is_plain = fields_.size() == 1 && field_of_store_.empty();
  const bool is_double = is_plain && fields_[0] == PointField::positions && doubles_;
  const std::string type = is_plain ? (is_double ? "'<f8'" : "'<f4'") : dtype();
  const bool is_triple = is_plain && fields_[0] != PointField::values;
  std::string text = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({},{}), }}",
                                 type, count, is_triple ? " 3" : "");
  // Magic number, version and length, 10 bytes; records begin at a multiple of 64.
  constexpr size_t kBefore = 10, kAlignment = 64;
  const size_t total = (kBefore + text.size() + 1 + kAlignment - 1) / kAlignment * kAlignment;
  text.resize(total - kBefore - 1, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xff);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

void PointRecords::append(const PointArrays& points, std::span<const float> field_values,
                          std::vector<std::byte>& out) const {
  const size_t before = out.size();
  out.resize(before + points.positions.size() * bytes());
  std::byte* at = out.data() + before;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    for (const PointField field : fields_) {
      if (field == PointField::positions) {
        const Vec3d p = points.positions[i];
        for (const double coordinate : {p.x, p.y, p.z}) {
          if (doubles_) {
            put(at, coordinate);
          } else {
            put(at, static_cast<float>(coordinate));
          }
        }
      } else if (field == PointField::normals) {
        const Vec3f n = points.normals[i];
        for (const float coordinate : {n.x, n.y, n.z}) put(at, coordinate);
      } else {
        put(at, points.values[i]);
      }
    }
    if (!field_of_store_.empty()) put(at, field_values[i]);
  }
}

}  // namespace isosplat::server
