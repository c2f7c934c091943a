#include "shared/import/vtk/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/text/header_text.h"
#include "shared/import/text/line_scanner.h"

namespace isosplat::import {
namespace {

struct TypeName {
  std::optional<VoxelType> type;
  size_t bytes = 0;  ///< 0: bits, eight to a byte
};

/// long and vtkIdType have 8 bytes, as on every 64-bit system except Windows.
std::optional<TypeName> type_named(const std::string& name) {
  static const std::map<std::string, TypeName> kTypes = {
      {"bit", {std::nullopt, 0}},
      {"unsigned_char", {VoxelType::u8, 1}},
      {"char", {VoxelType::i8, 1}},
      {"signed_char", {VoxelType::i8, 1}},
      {"unsigned_short", {VoxelType::u16, 2}},
      {"short", {VoxelType::i16, 2}},
      {"unsigned_int", {VoxelType::u32, 4}},
      {"int", {VoxelType::i32, 4}},
      {"unsigned_long", {VoxelType::u64, 8}},
      {"long", {VoxelType::i64, 8}},
      {"vtktypeint64", {VoxelType::i64, 8}},
      {"vtktypeuint64", {VoxelType::u64, 8}},
      {"vtkidtype", {VoxelType::i32, 4}},  // legacy files write ids as int
      {"float", {VoxelType::f32, 4}},
      {"double", {VoxelType::f64, 8}},
  };
  const auto found = kTypes.find(lower_case(name));
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

/// The name of an array, in which VTK writes blanks, quotes and other bytes as "%20". Control
/// characters stay as they are in the file.
std::string decoded(const std::string& name) {
  std::string text;
  for (size_t i = 0; i < name.size(); ++i) {
    int code = -1;
    if (name[i] == '%' && i + 2 < name.size()) {
      const char* const digits = name.data() + i + 1;
      const auto [end, error] = std::from_chars(digits, digits + 2, code, 16);
      if (error != std::errc{} || end != digits + 2) code = -1;
    }
    if (code < 0x20 || code == 0x7f) {
      text.push_back(name[i]);
      continue;
    }
    text.push_back(static_cast<char>(code));
    i += 2;
  }
  return text;
}

/// Reads the sections of one file.
class Parser {
  enum class Place : uint8_t { geometry, attribute, field };

 public:
  Parser(const std::filesystem::path& path, LineScanner scanner,
         const std::vector<std::string_view>& datasets)
      : path_(path), scanner_(std::move(scanner)), datasets_(datasets) {}

  Result<VtkFile> parse() {
    for (const bool is_version : {true, false}) {  // the version, and a title
      auto text = scanner_.line();
      if (!text) return tl::unexpected(text.error());
      if (is_version && *text) has_offsets_ = is_version_5(**text);
    }
    auto coding = scanner_.next_words();
    if (!coding) return tl::unexpected(coding.error());
    const std::string name = coding->empty() ? "" : lower_case(coding->front());
    if (name != "ascii" && name != "binary") {
      return scanner_.malformed(
          fmt::format("expected ASCII or BINARY in line 3, found '{}'", name));
    }
    file_.is_binary = name == "binary";
    for (;;) {
      auto parts = scanner_.next_words();
      if (!parts) {
        if (!has_points_scalars()) return tl::unexpected(parts.error());
        file_.has_surplus = true;
        return finish();
      }
      if (parts->empty()) return finish();
      if (auto done = section(*parts); !done) {
        // Sections after the array that is read may be unknown, but must begin with a name.
        file_.has_surplus = !file_.ends_early && !is_name(parts->front());
        if (has_points_scalars() || file_.ends_early) return finish();
        return tl::unexpected(done.error());
      }
    }
  }

 private:
  static bool is_name(std::string_view word) {
    const auto is_letter = [](char c) {
      return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
    };
    return is_letter(word.front()) && std::all_of(word.begin(), word.end(), [&](char c) {
             return is_letter(c) || (c >= '0' && c <= '9');
           });
  }

  bool has_points_scalars() const {
    return std::any_of(file_.arrays.begin(), file_.arrays.end(), [](const VtkArray& a) {
      return !a.of_cells && !a.is_field && a.components == 1 && a.type;
    });
  }

  Result<VtkFile> finish() {
    if (file_.dataset.empty()) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected DATASET STRUCTURED_POINTS or RECTILINEAR_GRID, found "
                              "the end of the file: "
                              "only regular grids are volumes",
                              path_.string()));
    }
    if (!has_dimensions_ && file_.dataset != "unstructured_grid")
      return scanner_.malformed("expected DIMENSIONS, found none");
    return file_;
  }

  Result<void> section(const std::vector<std::string>& parts) {
    const std::string key = lower_case(parts[0]);
    if (key == "dataset") return dataset(parts);
    if (key == "dimensions") {
      const auto numbers = triple(parts);
      if (!numbers) return tl::unexpected(numbers.error());
      for (const double n : {numbers->x, numbers->y, numbers->z}) {
        if (!(n >= 1 && n < 1e12 && n == std::floor(n))) {
          return scanner_.malformed("expected DIMENSIONS above 0");
        }
      }
      file_.dimensions = {static_cast<int64_t>(numbers->x), static_cast<int64_t>(numbers->y),
                          static_cast<int64_t>(numbers->z)};
      has_dimensions_ = true;
      return check_repetition(key, *numbers);
    }
    if (key == "spacing" || key == "aspect_ratio" || key == "origin") {
      const auto numbers = triple(parts);
      if (!numbers) return tl::unexpected(numbers.error());
      (key == "origin" ? file_.origin : file_.spacing) = *numbers;
      if (key != "origin") file_.has_no_spacing = false;
      return check_repetition(key == "origin" ? key : "spacing", *numbers);
    }
    if (key == "point_data" || key == "cell_data") {
      const auto count = parts.size() > 1 ? whole_number(parts[1]) : std::nullopt;
      if (!count || *count < 0)
        return scanner_.malformed(fmt::format("expected a number after {}", key));
      values_ = static_cast<uint64_t>(*count);
      of_cells_ = key == "cell_data";
      in_data_ = true;
      file_.has_point_data = file_.has_point_data || !of_cells_;
      return {};
    }
    if (key == "metadata") return metadata();
    if (key == "field") return field(parts);
    if (key == "points" || key == "x_coordinates" || key == "y_coordinates" ||
        key == "z_coordinates") {
      return positions(key, parts);
    }
    if (key == "cells" || key == "cell_types") return cells(key, parts);
    return attribute(key, parts);
  }

  Result<void> dataset(const std::vector<std::string>& parts) {
    const std::string name = parts.size() > 1 ? lower_case(parts[1]) : "nothing";
    if (std::find(datasets_.begin(), datasets_.end(), name) == datasets_.end()) {
      const bool is_mesh = name == "unstructured_grid" || name == "structured_grid";
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected DATASET STRUCTURED_POINTS or RECTILINEAR_GRID, found {}: "
                      "only regular grids are volumes; {}",
                      path_.string(), name,
                      is_mesh ? "isosplat build makes a scene of it"
                              : "resample it to an image (in ParaView: Resample To Image)"));
    }
    file_.dataset = name;
    return {};
  }

  static bool is_version_5(const std::string& line) {
    const auto parts = words(line);
    const std::string_view version = parts.empty() ? "" : parts.back();
    const auto major = whole_number(version.substr(0, version.find('.')));
    return major && *major >= 5;
  }

  /// POINTS n type, X_COORDINATES n type.
  Result<void> positions(const std::string& key, const std::vector<std::string>& parts) {
    const auto count = parts.size() > 2 ? whole_number(parts[1]) : std::nullopt;
    if (!count || *count < 0) {
      return scanner_.malformed(fmt::format("expected a number and a type after {}", parts[0]));
    }
    return add(key, parts[2], key == "points" ? 3 : 1, static_cast<uint64_t>(*count),
               Place::geometry);
  }

  /// CELLS cells numbers, with the number of each cell's points before them; from version 5 on
  /// CELLS offsets numbers, with the sections OFFSETS and CONNECTIVITY. CELL_TYPES cells.
  Result<void> cells(const std::string& key, const std::vector<std::string>& parts) {
    const auto number = [&](size_t i) {
      return parts.size() > i ? whole_number(parts[i]).value_or(-1) : -1;
    };
    const bool are_types = key == "cell_types";
    const int64_t count = number(1), numbers = number(are_types ? 1 : 2);
    if (count < 0 || numbers < 0) {
      return scanner_.malformed(fmt::format("expected numbers after {}", parts[0]));
    }
    if (are_types || !has_offsets_) {
      return add(key, "int", 1, static_cast<uint64_t>(numbers), Place::geometry);
    }
    for (const bool are_offsets : {true, false}) {
      const char* const name = are_offsets ? "offsets" : "connectivity";
      const auto words = scanner_.next_words();
      if (!words) return tl::unexpected(words.error());
      if (words->size() < 2 || lower_case(words->front()) != name) {
        return scanner_.malformed(fmt::format("expected {} and a type after CELLS", name));
      }
      if (auto added = add(name, (*words)[1], 1,
                           static_cast<uint64_t>(are_offsets ? count : numbers), Place::geometry);
          !added) {
        return added;
      }
    }
    return {};
  }

  Result<Vec3d> triple(const std::vector<std::string>& parts) {
    const auto x = parts.size() > 3 ? number_in(parts[1]) : std::nullopt;
    const auto y = parts.size() > 3 ? number_in(parts[2]) : std::nullopt;
    const auto z = parts.size() > 3 ? number_in(parts[3]) : std::nullopt;
    if (x && y && z) return Vec3d{*x, *y, *z};
    return scanner_.malformed(fmt::format("expected three numbers after {}", parts[0]));
  }

  /// Errors: malformed_volume if a field occurs twice with different numbers.
  Result<void> check_repetition(const std::string& name, Vec3d numbers) {
    const auto [at, is_new] = numbers_of_.try_emplace(name, numbers);
    if (is_new || at->second == numbers) return {};
    return scanner_.malformed(fmt::format("the {} occurs twice with different numbers", name));
  }

  /// Skips lines up to an empty one. Names of components may be empty lines.
  Result<void> metadata() {
    int64_t names = 0;
    for (;;) {
      const auto text = scanner_.line();
      if (!text) return tl::unexpected(text.error());
      if (!*text) return {};
      const std::string_view line = trimmed(**text);
      if (line.empty() && names <= 0) return {};
      names = lower_case(line) == "component_names" ? components_ : names - 1;
    }
  }

  /// Skips strings: a line for each, or its length and its bytes (vtkDataWriter::WriteArray).
  Result<void> skip_strings(int64_t components, int64_t tuples) {
    constexpr int64_t kMost = int64_t{1} << 40;
    if (components < 0 || components > 1000 || tuples > kMost) {
      return scanner_.malformed("expected fewer strings in a FIELD");
    }
    for (int64_t left = components * tuples; left > 0; --left) {
      const auto skipped_one = file_.is_binary ? skip_string() : skip_line();
      if (!skipped_one) return skipped_one;
    }
    return {};
  }

  Result<void> skip_line() {
    const auto text = scanner_.line();
    if (!text) return tl::unexpected(text.error());
    return skipped(text->has_value());
  }

  /// The first two bits of a length state its bytes: 8, 4, 2 or 1, big-endian.
  Result<void> skip_string() {
    const auto first = scanner_.byte();
    if (!first) return tl::unexpected(first.error());
    if (*first < 0) return skipped(false);
    auto length = static_cast<uint64_t>(*first & 0x3f);
    for (int more = (8 >> (*first >> 6)) - 1; more > 0; --more) {
      const auto next = scanner_.byte();
      if (!next) return tl::unexpected(next.error());
      if (*next < 0) return skipped(false);
      length = length << 8 | static_cast<uint64_t>(*next);
    }
    return skipped(scanner_.skip_bytes(length));
  }

  /// Records an array whose values begin here, and skips the values.
  Result<void> add(std::string name, const std::string& type_name, int64_t components,
                   uint64_t values, Place place) {
    const auto type = type_named(type_name);
    components_ = components;
    uint64_t numbers = 0;
    if (components < 1 || components > 1000 ||
        __builtin_mul_overflow(values, static_cast<uint64_t>(components), &numbers)) {
      return scanner_.malformed(fmt::format("the array '{}' is too large", name));
    }
    if (!type && file_.is_binary) {
      return scanner_.malformed(
          fmt::format("the array '{}' has the unknown type {}", name, type_name));
    }
    VtkArray* added = nullptr;
    if (in_data_ || place == Place::geometry) {
      VtkArray array;
      array.name = place == Place::geometry ? std::move(name) : decoded(name);
      array.of_cells = of_cells_;
      array.is_field = place == Place::field;
      array.components = static_cast<int>(components);
      if (type) array.type = type->type;
      array.type_name = type_name;
      array.values = values;
      array.offset = scanner_.position();
      auto& arrays = place == Place::geometry ? file_.geometry : file_.arrays;
      added = &arrays.emplace_back(std::move(array));
    }
    auto done = skip_values(numbers, type ? type->bytes : 0);
    if (added) added->end = scanner_.position();
    return done;
  }

  Result<void> skip_values(uint64_t numbers, size_t value_bytes) {
    if (!file_.is_binary) return skipped(scanner_.skip_numbers(numbers));
    uint64_t bytes = 0;
    if (value_bytes == 0) {
      bytes = numbers / 8 + (numbers % 8 > 0 ? 1 : 0);
    } else if (__builtin_mul_overflow(numbers, value_bytes, &bytes)) {
      bytes = UINT64_MAX;
    }
    return skipped(scanner_.skip_bytes(bytes));
  }

  /// Checks the result of skipping values. Errors: read errors, and one for the end of the file.
  Result<void> skipped(Result<bool> all) {
    if (!all) return tl::unexpected(all.error());
    if (*all) return {};
    file_.ends_early = true;
    return scanner_.malformed("expected more values, found the end of the file");
  }

  /// FIELD name arrays, followed for each array by: name components tuples type, and the values.
  Result<void> field(const std::vector<std::string>& parts) {
    const auto arrays = parts.size() > 2 ? whole_number(parts[2]) : std::nullopt;
    if (!arrays || *arrays < 0) return scanner_.malformed("expected FIELD, a name and a number");
    for (int64_t i = 0; i < *arrays; ++i) {
      auto words = scanner_.next_words();
      if (!words) return tl::unexpected(words.error());
      if (!words->empty() && lower_case(words->front()) == "metadata") {
        if (auto passed = metadata(); !passed) return passed;
        --i;
        continue;
      }
      const auto components = words->size() > 3 ? whole_number((*words)[1]) : std::nullopt;
      const auto tuples = words->size() > 3 ? whole_number((*words)[2]) : std::nullopt;
      if (!components || !tuples || *tuples < 0) {
        return scanner_.malformed("expected a FIELD's name, components, tuples and type");
      }
      if (lower_case((*words)[3]) == "string") {
        if (auto passed = skip_strings(*components, *tuples); !passed) return passed;
        continue;
      }
      if (auto added = add((*words)[0], (*words)[3], *components, static_cast<uint64_t>(*tuples),
                           Place::field);
          !added) {
        return added;
      }
    }
    return {};
  }

  Result<void> attribute(const std::string& key, const std::vector<std::string>& parts) {
    const std::string name = parts.size() > 1 ? parts[1] : "";
    const std::string type = parts.size() > 2 ? parts[2] : "";
    if (key == "scalars") {
      const auto components = parts.size() > 3 ? whole_number(parts[3]) : 1;
      if (parts.size() < 3 || !components) {
        return scanner_.malformed("expected SCALARS, a name and a type");
      }
      const auto table = scanner_.next_words();
      if (!table) return tl::unexpected(table.error());
      if (table->empty() || lower_case(table->front()) != "lookup_table") {
        return scanner_.malformed("expected LOOKUP_TABLE after SCALARS");
      }
      return add(name, type, *components, values_, Place::attribute);
    }
    if (key == "color_scalars") {
      const auto components = whole_number(type);
      if (!components) return scanner_.malformed("expected COLOR_SCALARS, a name and a number");
      return add(name, file_.is_binary ? "unsigned_char" : "float", *components, values_,
                 Place::attribute);
    }
    if (key == "lookup_table") {
      const auto entries = whole_number(type);
      if (!entries || *entries < 0)
        return scanner_.malformed("expected LOOKUP_TABLE, a name and a size");
      const uint64_t numbers = 4 * static_cast<uint64_t>(*entries);
      if (!file_.is_binary) return skipped(scanner_.skip_numbers(numbers));
      return skipped(scanner_.skip_bytes(numbers));
    }
    if (key == "global_ids" || key == "pedigree_ids") {
      return add(name, type, 1, values_, Place::attribute);
    }
    if (key == "vectors" || key == "normals") return add(name, type, 3, values_, Place::attribute);
    if (key == "tensors") return add(name, type, 9, values_, Place::attribute);
    if (key == "tensors6") return add(name, type, 6, values_, Place::attribute);
    if (key == "texture_coordinates" && parts.size() > 3) {
      return add(name, parts[3], whole_number(type).value_or(2), values_, Place::attribute);
    }
    return scanner_.malformed(fmt::format(
        "expected a section such as POINT_DATA or SCALARS, found '{}'", key.substr(0, 40)));
  }

  const std::filesystem::path& path_;
  LineScanner scanner_;
  VtkFile file_;
  std::map<std::string, Vec3d> numbers_of_;  ///< of the fields with three numbers
  const std::vector<std::string_view>& datasets_;
  bool has_dimensions_ = false, has_offsets_ = false;
  bool in_data_ = false, of_cells_ = false;
  uint64_t values_ = 0;
  int64_t components_ = 1;  ///< of the array before
};

}  // namespace

Result<VtkFile> read_vtk_sections(const std::filesystem::path& path,
                                  const std::vector<std::string_view>& datasets) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return Parser(path, LineScanner(path, std::move(*file), "VTK"), datasets).parse();
}

std::string vtk_dataset(std::string_view beginning) {
  if (!beginning.starts_with("# vtk DataFile")) return {};
  for (size_t line = 0, begin = 0; line < 100 && begin < beginning.size(); ++line) {
    const size_t end = std::min(beginning.find('\n', begin), beginning.size());
    const auto parts = words(beginning.substr(begin, end - begin));
    // The first three lines are the version, a title and the encoding.
    if (line >= 3 && parts.size() > 1 && lower_case(parts[0]) == "dataset") {
      return lower_case(parts[1]);
    }
    begin = end + 1;
  }
  return {};
}

}  // namespace isosplat::import
