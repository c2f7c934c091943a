#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// The name of a volume or a scene depends only on the path of its file, and different paths of one
// kind have different names. So a token or a link for a name never opens another file, whatever
// other files are in the folders when the server starts.
namespace isosplat::server {

/// The kinds of files that a server serves. Each kind has separate names.
enum class ServedKind : uint8_t {
  volume,  ///< a store
  scene    ///< a bundle, or a document beside its stores
};

/// "volume" or "scene".
std::string_view word_of(ServedKind kind);

/// The file extension of stores.
inline constexpr std::string_view kStoreExtension = ".isosplat";

/// The file extension of bundles.
inline constexpr std::string_view kBundleExtension = ".isobundle";

/// Whether a file is a scene, by its name: a bundle, or a document (scene.json, NAME.scene.json).
/// Every other file that is named as a source is a store.
bool is_scene_file(std::string_view file_name);

/// Whether a folder's file is served as this kind: *.isosplat, or a scene; not if its name begins
/// with ".".
bool is_listed(std::string_view file_name, ServedKind kind);

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

/// The name of a file without kStoreExtension, kBundleExtension, or, for scene documents, ".json".
/// If a bundle's name would then be that of a document (scene.isobundle, x.scene.isobundle), the
/// whole name.
std::string stem_of_file(const std::filesystem::path& file);

/// The last segment of the name of the volume or the scene in a file.
std::string file_segment(const std::filesystem::path& file);

/// The properties of a volume or a scene that access rules use, in addition to its name.
struct VolumeIdentity {
  /// The segments of its path before they were converted for the name; empty: equal to those of the
  /// name.
  std::vector<std::string> unaltered;
  std::string folder;  ///< of its file; absolute, with links resolved
  std::string file;    ///< the name of its file in this folder
  ServedKind kind = ServedKind::volume;
};

/// A source of stores and scenes as it was given, and the beginning of its names.
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
