#include "server/volume_names.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>

namespace isosplat {
namespace {

constexpr size_t kMaxSegment = 128;

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

/// What remains of a text, at most `longest` characters.
std::string name_characters(std::string_view text, size_t longest) {
  std::string name;
  for (const char c : text) {
    if (is_name_character(c)) {
      name += c;
    } else if (!name.ends_with('-')) {
      name += '-';
    }
  }
  name.erase(0, std::min(name.find_first_not_of("-."), name.size()));
  name.resize(std::min(name.size(), longest));
  while (name.ends_with('-') || name.ends_with('.')) name.pop_back();
  return name.empty() ? "volume" : name;
}

}  // namespace

std::string url_name(const std::filesystem::path& path) {
  const std::string file = path.filename().string();
  std::string_view stem = file;
  if (stem.ends_with(kStoreExtension)) stem.remove_suffix(kStoreExtension.size());
  return name_characters(stem, kMaxSegment);
}

std::string folder_url_name(std::string_view folder) {
  const std::string name = name_characters(folder, kMaxSegment);
  if (name == folder) return name;
  const auto hash = static_cast<uint32_t>(XXH3_64bits(folder.data(), folder.size()));
  const std::string suffix = fmt::format("-{:08x}", hash);
  return name_characters(folder, kMaxSegment - suffix.size()) + suffix;
}

const std::string& VolumeNames::of(const std::string& path, const std::string& wanted) {
  const auto [item, is_new] = names_.try_emplace(path);
  if (!is_new) return item->second;
  std::string name = wanted;
  if (!used_.insert(name).second) {
    uint32_t& next = next_.try_emplace(wanted, 2).first->second;
    do {
      name = fmt::format("{}-{}", wanted, next++);
    } while (!used_.insert(name).second);
  }
  return item->second = std::move(name);
}

}  // namespace isosplat
