#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// The name of a volume depends only on the path of its store, and different paths have different
// names. So a token or a link for a name never opens another store, whatever other stores are in
// the folders when the server starts.
namespace isosplat::server {

/// The file extension of stores.
inline constexpr std::string_view kStoreExtension = ".isosplat";

/// Separates the segments of a name: "ct~head". No segment contains it, and it needs no escape in
/// URLs, cookies and shells.
inline constexpr char kFolderSeparator = '~';

/// A segment of a volume's name, computed from the name of a folder, or of a file without
/// kStoreExtension. Each run of characters other than letters, digits, "-", "_" and "." becomes one
/// "-"; "." and "-" at the ends are removed; at most 128 characters are kept. If this changes the
/// text, "--" and 8 hexadecimal digits of its XXH3 are appended, so that different texts have
/// different segments. They are also appended to a text that already ends in such a hash. Never
/// empty.
std::string name_segment(std::string_view text);

/// Whether a text could be a volume's name.
bool is_volume_name(std::string_view text);

/// The name of a file without kStoreExtension.
std::string stem_of_store(const std::filesystem::path& file);

/// The properties of a volume that access rules use, in addition to its name.
struct VolumeIdentity {
  /// The segments of its path before they were converted for the name; empty: equal to those of the
  /// name.
  std::vector<std::string> unaltered;
  std::string folder;  ///< of its store; absolute, with links resolved
  std::string file;    ///< the name of the store's file in this folder
};

/// A source of stores as it was given, and the beginning of its names.
struct NamedSource {
  std::filesystem::path path;
  bool is_folder = false;
  /// The label of the source, if its names have one: as it appears in names ("ct"), and in the form
  /// that patterns of access rules are compared with. Both empty: no label.
  std::string label, unaltered;
};

/// The sources of a server, without those inside of other sources. A single source, or several
/// files with different names, have no label. Otherwise the label of each source is the name of the
/// folder (for a file, of the folder that contains it). If different folders have the same name, a
/// hash of its path is appended to each label. So names depend neither on the content of folders
/// nor on the order of sources. A path that is not a folder at this time counts as a file.
std::vector<NamedSource> named_sources(const std::vector<std::filesystem::path>& sources);

}  // namespace isosplat::server
