#include "shared/import/vtk/sections.h"

#include <fmt/format.h>

#include <algorithm>
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

/// Reads the sections of one file.
class Parser {
 public:
  Parser(const std::filesystem::path& path, LineScanner scanner)
      : path_(path), scanner_(std::move(scanner)) {}

  Result<VtkFile> parse() {
    for (int i = 0; i < 2; ++i) {  // the version and a title
      if (auto text = scanner_.line(); !text) return tl::unexpected(text.error());
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
    if (!is_structured_points_) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected DATASET STRUCTURED_POINTS, found the end of the file: "
                              "only regular grids are volumes",
                              path_.string()));
    }
    if (!has_dimensions_) return scanner_.malformed("expected DIMENSIONS, found none");
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
    return attribute(key, parts);
  }

  Result<void> dataset(const std::vector<std::string>& parts) {
    const std::string name = parts.size() > 1 ? lower_case(parts[1]) : "nothing";
    if (name != "structured_points") {
      return fail(
          Status::unsupported_format,
          fmt::format("{}: expected DATASET STRUCTURED_POINTS, found {}: only regular grids "
                      "are volumes; resample it to an image (in ParaView: Resample To "
                      "Image)",
                      path_.string(), name));
    }
    is_structured_points_ = true;
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

  /// Skips lines up to an empty one.
  Result<void> metadata() {
    for (;;) {
      const auto text = scanner_.line();
      if (!text) return tl::unexpected(text.error());
      if (!*text || trimmed(**text).empty()) return {};
    }
  }

  /// Records an array whose values begin here, and skips the values.
  Result<void> add(std::string name, const std::string& type_name, int64_t components,
                   uint64_t values, bool is_field) {
    const auto type = type_named(type_name);
    uint64_t numbers = 0;
    if (components < 1 || components > 1000 ||
        __builtin_mul_overflow(values, static_cast<uint64_t>(components), &numbers)) {
      return scanner_.malformed(fmt::format("the array '{}' is too large", name));
    }
    if (!type && file_.is_binary) {
      return scanner_.malformed(
          fmt::format("the array '{}' has the unknown type {}", name, type_name));
    }
    if (in_data_) {
      VtkArray array;
      array.name = std::move(name);
      array.of_cells = of_cells_;
      array.is_field = is_field;
      array.components = static_cast<int>(components);
      if (type) array.type = type->type;
      array.type_name = type_name;
      array.values = values;
      array.offset = scanner_.position();
      file_.arrays.push_back(std::move(array));
    }
    if (!file_.is_binary) return skipped(scanner_.skip_numbers(numbers));
    uint64_t bytes = 0;
    if (type->bytes == 0) {
      bytes = (numbers + 7) / 8;
    } else if (__builtin_mul_overflow(numbers, type->bytes, &bytes)) {
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
        return scanner_.malformed("expected numbers in a FIELD, found strings");
      }
      if (auto added =
              add((*words)[0], (*words)[3], *components, static_cast<uint64_t>(*tuples), true);
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
      return add(name, type, *components, values_, false);
    }
    if (key == "color_scalars") {
      const auto components = whole_number(type);
      if (!components) return scanner_.malformed("expected COLOR_SCALARS, a name and a number");
      return add(name, file_.is_binary ? "unsigned_char" : "float",
                 std::max<int64_t>(*components, 2), values_, false);
    }
    if (key == "lookup_table") {
      const auto entries = whole_number(type);
      if (!entries || *entries < 0)
        return scanner_.malformed("expected LOOKUP_TABLE, a name and a size");
      const uint64_t numbers = 4 * static_cast<uint64_t>(*entries);
      if (!file_.is_binary) return skipped(scanner_.skip_numbers(numbers));
      return skipped(scanner_.skip_bytes(numbers));
    }
    if (key == "vectors" || key == "normals") return add(name, type, 3, values_, false);
    if (key == "tensors") return add(name, type, 9, values_, false);
    if (key == "texture_coordinates" && parts.size() > 3) {
      return add(name, parts[3], std::max<int64_t>(whole_number(type).value_or(2), 2), values_,
                 false);
    }
    return scanner_.malformed(fmt::format(
        "expected a section such as POINT_DATA or SCALARS, found '{}'", key.substr(0, 40)));
  }

  const std::filesystem::path& path_;
  LineScanner scanner_;
  VtkFile file_;
  std::map<std::string, Vec3d> numbers_of_;  ///< of the fields with three numbers
  bool is_structured_points_ = false, has_dimensions_ = false;
  bool in_data_ = false, of_cells_ = false;
  uint64_t values_ = 0;
};

}  // namespace

Result<VtkFile> read_vtk_sections(const std::filesystem::path& path) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return Parser(path, LineScanner(path, std::move(*file), "VTK")).parse();
}

}  // namespace isosplat::import
