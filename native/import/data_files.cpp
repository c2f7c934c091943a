#include "native/import/data_files.h"

#include <fmt/format.h>

#include "native/import/header_text.h"

namespace isosplat {
namespace {

constexpr size_t kMaxFiles = 1'000'000;
constexpr size_t kMaxListBytes = 64 << 20;

/// "%03d" → 3; nothing for any other conversion.
std::optional<int64_t> width_of(std::string_view conversion) {
  if (conversion.size() < 2 || conversion.front() != '%' || conversion.back() != 'd') return {};
  conversion = conversion.substr(1, conversion.size() - 2);
  if (conversion.empty()) return 0;
  const auto width = whole_number(conversion);
  return width && *width >= 0 && *width <= 32 ? width : std::nullopt;
}

std::vector<std::string> listed(const std::filesystem::path& header) {
  const auto text = read_beginning(header, kMaxListBytes);
  if (!text) return {};
  std::vector<std::string> names;
  std::string_view rest = *text;
  bool in_list = false;
  while (!rest.empty() && names.size() < kMaxFiles) {
    auto line = take_line(rest);
    if (!line) line = std::exchange(rest, {});
    const std::string_view name = trimmed(*line);
    if (in_list && !name.empty()) names.emplace_back(name);
    const std::string lower = lower_case(name);
    const size_t value = lower.find_first_of(":=");
    if (value != lower.npos && (lower.starts_with("data file") || lower.starts_with("datafile") ||
                                lower.starts_with("elementdatafile"))) {
      in_list = true;
    }
  }
  return names;
}

std::vector<std::string> numbered(std::string_view value) {
  const auto parts = words(value);
  if (parts.size() < 3) return {};
  const std::string_view pattern = parts[0];
  const size_t begin = pattern.find('%'), end = pattern.find('d', begin);
  const auto first = whole_number(parts[1]), last = whole_number(parts[2]);
  const auto step = parts.size() > 3 ? whole_number(parts[3]) : 1;
  if (end == pattern.npos || !first || !last || !step || *step == 0) return {};
  const auto width = width_of(pattern.substr(begin, end + 1 - begin));
  if (!width) return {};
  std::vector<std::string> names;
  for (int64_t i = *first; (*step > 0 ? i <= *last : i >= *last) && names.size() < kMaxFiles;) {
    names.push_back(
        fmt::format("{}{:0{}}{}", pattern.substr(0, begin), i, *width, pattern.substr(end + 1)));
    if (__builtin_add_overflow(i, *step, &i)) break;
  }
  return names;
}

}  // namespace

std::vector<std::filesystem::path> named_data_files(const std::filesystem::path& header,
                                                    std::string_view value) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name :
       lower_case(value).starts_with("list") ? listed(header) : numbered(value)) {
    const std::filesystem::path file(name);
    files.push_back(file.is_relative() ? header.parent_path() / file : file);
  }
  return files;
}

}  // namespace isosplat
