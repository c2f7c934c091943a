#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace isosplat {

/// How the files of stores end.
inline constexpr std::string_view kStoreExtension = ".isosplat";

/// Between the folders of a name: "ct~head". No segment of a name contains it, and URLs, cookies
/// and shells take it as it is.
inline constexpr char kFolderSeparator = '~';

/// The name of a store in URLs: the stem of its file name, in which each run of characters other
/// than letters, digits, "-", "_" and "." becomes one "-", without leading "." and "-". Never
/// empty.
std::string url_name(const std::filesystem::path& path);

/// The name of a folder in the names of its stores. Its characters are replaced as in url_name();
/// if that changes it, "-" and 8 hexadecimal digits of XXH3 of the folder's name follow, so that
/// different folders have different names: rules of access and links name them.
std::string folder_url_name(std::string_view folder);

/// Names of paths: unique, and the same for a path as long as it is known. Not thread-safe.
class VolumeNames {
 public:
  /// The name of a path. A new one is `wanted`; if that is taken, `wanted`-2, and so on.
  const std::string& of(const std::string& path, const std::string& wanted);

  /// Forgets all paths for which `is_known(path)` is false.
  template <class IsKnown>
  void keep_only(IsKnown is_known) {
    std::erase_if(names_, [&](const auto& item) {
      if (is_known(item.first)) return false;
      used_.erase(item.second);
      return true;
    });
    next_.clear();
  }

  size_t size() const { return names_.size(); }

 private:
  std::map<std::string, std::string> names_;  ///< by path
  std::set<std::string> used_;
  std::map<std::string, uint32_t> next_;  ///< the number to try, by wanted name
};

}  // namespace isosplat
