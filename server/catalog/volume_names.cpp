#include "server/catalog/volume_names.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

namespace isosplat::server {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxSegment = 128;
constexpr std::string_view kHashMark = "--";
constexpr size_t kHashDigits = 8;

/// Whether the name of a file without ".json" is that of a scene document.
bool is_document_stem(std::string_view stem) {
  return stem == "scene" || stem.ends_with(".scene");
}

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

/// The characters of a text that a name keeps, at most `longest` of them.
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

/// Whether a text ends in a hash, as a converted name does.
bool has_hash(std::string_view text) {
  if (text.size() < kHashMark.size() + kHashDigits) return false;
  const std::string_view end = text.substr(text.size() - kHashMark.size() - kHashDigits);
  return end.starts_with(kHashMark) &&
         std::ranges::all_of(end.substr(kHashMark.size()), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

/// A name followed by a hash of a text.
std::string with_hash(std::string_view name, std::string_view text) {
  const auto hash = static_cast<uint32_t>(XXH3_64bits(text.data(), text.size()));
  const std::string suffix = fmt::format("{}{:08x}", kHashMark, hash);
  return name_characters(name, kMaxSegment - suffix.size()) + suffix;
}

/// An absolute path, without "." and "..", and without a "/" at the end. Links are not resolved.
fs::path plain_path(const fs::path& path) {
  std::error_code ignored;
  fs::path plain = fs::absolute(path, ignored).lexically_normal();
  if (!plain.has_filename() && plain.has_relative_path()) plain = plain.parent_path();
  return plain;
}

fs::path with_links_resolved(const fs::path& path) {
  std::error_code ignored;
  return fs::weakly_canonical(path, ignored);
}

/// Whether the listing of a folder finds a path: the path is below it, and no part of it is hidden.
bool lists(const fs::path& folder, const fs::path& path, bool is_folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  if (end != folder.end()) return false;
  const bool is_hidden = std::any_of(
      rest, path.end(), [](const fs::path& part) { return part.native().starts_with('.'); });
  return !is_hidden && (is_folder || path.native().ends_with(kStoreExtension) ||
                        is_scene_file(path.filename().native()));
}

struct Source {
  NamedSource named;
  fs::path real;          ///< with links resolved; for a file, those of its folder
  fs::path label_folder;  ///< the folder whose name is the label
};

std::vector<Source> without_nested(const std::vector<fs::path>& given) {
  std::vector<Source> all;
  for (const fs::path& path : given) {
    Source source;
    source.named.path = path;
    if (!path.has_filename() && path.has_relative_path()) source.named.path = path.parent_path();
    std::error_code ignored;
    source.named.is_folder = fs::is_directory(path, ignored);
    const fs::path plain = plain_path(path);
    source.label_folder = source.named.is_folder ? plain : plain.parent_path();
    source.real = source.named.is_folder
                      ? with_links_resolved(plain)
                      : with_links_resolved(plain.parent_path()) / plain.filename();
    all.push_back(std::move(source));
  }
  std::vector<Source> kept;
  for (size_t i = 0; i < all.size(); ++i) {
    const auto covers = [&](const Source& other) {
      const size_t j = static_cast<size_t>(&other - all.data());
      if (i == j) return false;
      if (all[i].real == other.real) return j < i;
      return other.named.is_folder && lists(other.real, all[i].real, all[i].named.is_folder);
    };
    if (std::ranges::none_of(all, covers)) kept.push_back(all[i]);
  }
  return kept;
}

}  // namespace

std::string name_segment(std::string_view text) {
  std::string name = name_characters(text, kMaxSegment);
  return name == text && !has_hash(text) ? name : with_hash(text, text);
}

bool is_volume_name(std::string_view text) {
  while (true) {
    const std::string_view segment = text.substr(0, text.find(kFolderSeparator));
    if (name_characters(segment, kMaxSegment) != segment) return false;
    if (segment.size() == text.size()) return true;
    text.remove_prefix(segment.size() + 1);
  }
}

std::string_view word_of(ServedKind kind) {
  return kind == ServedKind::volume ? "volume" : "scene";
}

bool is_scene_file(std::string_view file_name) {
  if (file_name.ends_with(kBundleExtension)) return true;
  constexpr std::string_view kJson = ".json";
  return file_name.ends_with(kJson) &&
         is_document_stem(file_name.substr(0, file_name.size() - kJson.size()));
}

bool is_listed(std::string_view file_name, ServedKind kind) {
  if (file_name.starts_with('.')) return false;
  return kind == ServedKind::volume ? file_name.ends_with(kStoreExtension)
                                    : is_scene_file(file_name);
}

std::string stem_of_file(const fs::path& file) {
  const std::string name = file.filename().string();
  const auto without = [&](size_t bytes) { return name.substr(0, name.size() - bytes); };
  if (name.ends_with(kStoreExtension)) return without(kStoreExtension.size());
  if (name.ends_with(kBundleExtension)) {
    std::string stem = without(kBundleExtension.size());
    return is_document_stem(stem) ? name : stem;
  }
  return is_scene_file(name) ? without(std::string_view(".json").size()) : name;
}

std::string file_segment(const fs::path& file) {
  const std::string stem = stem_of_file(file);
  // A bundle that keeps its extension gets a hash, since x.isobundle.isobundle has this name.
  const bool is_ambiguous = stem.ends_with(kBundleExtension) && stem == file.filename().string();
  return is_ambiguous ? with_hash(stem, stem + '/') : name_segment(stem);
}

std::vector<NamedSource> named_sources(const std::vector<fs::path>& given) {
  std::vector<Source> sources = without_nested(given);
  std::set<std::string> stems;
  const bool are_different_files = std::ranges::all_of(sources, [&](const Source& source) {
    return !source.named.is_folder && stems.insert(stem_of_file(source.named.path)).second;
  });
  if (sources.size() > 1 && !are_different_files) {
    std::map<std::string, std::set<fs::path>> folders;  // by label
    for (const Source& source : sources) {
      folders[source.label_folder.filename().string()].insert(source.label_folder);
    }
    for (Source& source : sources) {
      const std::string text = source.label_folder.filename().string();
      const bool is_unique = folders[text].size() == 1;
      const std::string path = source.label_folder.string();
      source.named.label = is_unique ? name_segment(text) : with_hash(text, path);
      source.named.unaltered = is_unique ? text : path;
    }
  }
  std::vector<NamedSource> named;
  for (Source& source : sources) named.push_back(std::move(source.named));
  return named;
}

}  // namespace isosplat::server
