#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// The name of a volume follows from the path of its store alone, and different paths have different
// names: a token or a link for a name never opens another store, whatever else is in the folders
// when the server starts.
namespace isosplat::server {

/// How the files of stores end.
inline constexpr std::string_view kStoreExtension = ".isosplat";

/// Between the folders of a name: "ct~head". No segment of a name contains it, and URLs, cookies
/// and shells take it as it is.
inline constexpr char kFolderSeparator = '~';

/// A segment of a volume's name, of the name of a folder, or of a file without kStoreExtension.
/// Each run of characters other than letters, digits, "-", "_" and "." becomes one "-"; "." and "-"
/// at the ends are removed; at most 128 characters are kept. If that changes the text, "--" and 8
/// hexadecimal digits of XXH3 of it follow, so that different texts have different segments; and so
/// for a text that already ends like this. Never empty.
std::string name_segment(std::string_view text);

/// Whether a text could be a volume's name.
bool is_volume_name(std::string_view text);

/// The name of a file without kStoreExtension.
std::string stem_of_store(const std::filesystem::path& file);

/// What access rules are compared with, besides the name.
struct VolumeIdentity {
  /// The segments of its path before they were altered for the name; empty: those of the name.
  std::vector<std::string> unaltered;
  std::string folder;  ///< of its store; absolute, with links resolved
  std::string file;    ///< the name of its store there
};

/// A source of stores as it was given, and how the names of its stores begin.
struct NamedSource {
  std::filesystem::path path;
  bool is_folder = false;
  /// The label of the source, if its names have one: in the text of names ("ct"), and as patterns
  /// of access rules are compared with it. Both empty: none.
  std::string label, unaltered;
};

/// The sources of a server, without those that are within another one. One source, or several
/// files whose names differ, have no label. Otherwise each source has one: the name of the folder
/// (of a file: of the folder that it is in). If those of different folders are equal, each of them
/// has a hash of its path. So names do not depend on what is in the folders, nor on the order of
/// sources. A path that is not a folder now is a file's.
std::vector<NamedSource> named_sources(const std::vector<std::filesystem::path>& sources);

}  // namespace isosplat::server
