#include "native/extract/field_reading.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "shared/core/categories/categories.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat {

Result<OpenedFields> open_fields(const StoreFile& store, std::span<const std::string> names) {
  OpenedFields fields;
  for (size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(names.first(i), names[i]) != names.begin() + static_cast<ptrdiff_t>(i)) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': expected each field once, found it twice", names[i]));
    }
    const auto number = find_field(store.info(), names[i]);
    if (!number) {
      return fail(number.error().status, store.path().string() + ": " + number.error().message);
    }
    auto field = open_field(store, *number);
    if (!field) return tl::unexpected(field.error());
    fields.push_back(std::move(*field));
  }
  return fields;
}

bool has_field(const StoreInfo& store, const std::string& name) {
  return std::ranges::any_of(store.fields,
                             [&](const FieldRef& field) { return field.info.name == name; });
}

Result<OpenedFields> open_known_fields(const StoreFile& store,
                                       std::span<const FieldColumn> fields) {
  OpenedFields opened;
  for (const FieldColumn& field : fields) {
    if (!has_field(store.info(), field.name)) {
      opened.push_back(nullptr);
      continue;
    }
    auto one = open_fields(store, std::span(&field.name, 1));
    if (!one) return one;
    opened.push_back(std::move(one->front()));
  }
  return opened;
}

namespace {

FieldColumn column_of(const StoreFile& field) {
  using Json = nlohmann::json;
  FieldColumn column{field.info().field->name, {}, {}};
  const Json metadata = Json::parse(field.info().metadata, nullptr, /*allow_exceptions=*/false);
  if (!metadata.is_object()) return column;
  const auto text_of = [&](const char* key) {
    const auto found = metadata.find(key);
    return found != metadata.end() && found->is_string() ? found->get<std::string>() : "";
  };
  column.title = text_of("title");
  column.units = text_of("units");
  return column;
}

}  // namespace

std::vector<FieldColumn> columns_of(const OpenedFields& fields) {
  std::vector<FieldColumn> columns;
  for (const auto& field : fields) columns.push_back(column_of(*field));
  return columns;
}

std::vector<bool> are_categories(const OpenedFields& fields) {
  std::vector<bool> are;
  for (const auto& field : fields) {
    are.push_back(field && !categories_of(field->info().metadata).empty());
  }
  return are;
}

FieldReader::FieldReader(const OpenedFields& fields) : fields_(fields) {
  const std::vector<bool> is_category = are_categories(fields);
  for (size_t i = 0; i < fields.size(); ++i) {
    lattices_.push_back(fields[i]
                            ? std::optional<FieldLattice>(
                                  std::in_place, fields[i]->info().field->mapping, is_category[i])
                            : std::nullopt);
  }
}

Result<void> FieldReader::read(ChunkDecoder& decoder, const ChunkRef& chunk, Index3 block_cells,
                               std::span<const uint32_t> cells) {
  for (size_t i = 0; i < fields_.size(); ++i) {
    if (!fields_[i]) continue;
    const FieldInfo& info = *fields_[i]->info().field;
    const auto of_field = fields_[i]->chunk(chunk.block, chunk.band);
    if (!of_field) return tl::unexpected(of_field.error());
    bytes_.clear();
    if (auto read = fields_[i]->read_chunk(*of_field, bytes_); !read) return read;
    auto decoded =
        decoder.decode_field(bytes_, block_cells, cells, 1u << info.mapping.bits, corners_);
    if (!decoded) {
      return fail(decoded.error().status,
                  fmt::format("{}: chunk {}: {}", fields_[i]->path().filename().string(),
                              chunk_name(chunk.block, chunk.band), decoded.error().message));
    }
    lattices_[i]->set(cells, corners_);
  }
  return {};
}

template <class Point, class ValueAt>
FieldValues FieldReader::values_at(std::span<const Point> points, const ValueAt& value_at) const {
  FieldValues values(lattices_.size());
  for (size_t i = 0; i < values.size(); ++i) {
    values[i].assign(points.size(), std::numeric_limits<float>::quiet_NaN());
    if (!lattices_[i]) continue;
    std::ranges::transform(points, values[i].begin(),
                           [&](const Point& at) { return value_at(*lattices_[i], at); });
  }
  return values;
}

FieldValues FieldReader::at(std::span<const PointPlace> places) const {
  return values_at(places, [](const FieldLattice& lattice, const PointPlace& at) {
    return lattice.at(at.cell, at.in_cell);
  });
}

FieldValues FieldReader::at(std::span<const MeshVertex> vertices) const {
  return values_at(vertices, [](const FieldLattice& lattice, const MeshVertex& at) {
    return lattice.at(at.position);
  });
}

}  // namespace isosplat
