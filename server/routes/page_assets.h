#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/conditions.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The Content-Type of a file, by its extension.
std::string_view mime_type_of(std::string_view path);

/// One file of the page in one encoding.
struct AssetVariant {
  Encoding encoding = Encoding::identity;
  std::string bytes;
  std::string etag;  ///< with its quotes; strong, differs between encodings
};

struct Asset {
  std::string_view mime_type;
  bool immutable = false;              ///< the name contains a hash of the content
  std::vector<AssetVariant> variants;  ///< ascending in size; one is identity
};

/// The files of the built page, in memory. After links are resolved, they are the regular files
/// inside the folder, so no request can read files outside of it.
class PageAssets {
 public:
  using Log = std::function<void(std::string_view)>;

  /// Reads all files below `root`. Files F.br and F.gz beside F are encodings of F. If F.gz does
  /// not exist, text and WASM are compressed here. Errors: io_error, invalid_argument (more than
  /// `max_bytes` in all).
  static Result<std::shared_ptr<PageAssets>> load(const std::filesystem::path& root,
                                                  uint64_t max_bytes, const Log& log);

  /// `path`: decoded, e.g. "/assets/index-x7Hd9aK2.js"; "/" is "/index.html". Null: no such file.
  const Asset* find(std::string_view path) const;

  /// A hash of the paths, sizes and times of all files below `root`: it changes if a file is added,
  /// removed or written.
  static uint64_t signature(const std::filesystem::path& root);

  /// Hashed names, such as "/assets/index-x7Hd9aK2.js", to which an HTML file of the page refers
  /// but which do not exist. The page is then still being built, or its copy is incomplete.
  std::vector<std::string> missing() const;

  /// Keeps files with hashed names from the page `before` that this page no longer has, since
  /// browsers that have loaded the old page may still request them. They are kept for at least
  /// `kept_for`, and until the next change of the page after that. For files that `before` already
  /// kept, the time continues. Keeps at most `max_bytes`, the newest files first.
  void keep_hashed(const PageAssets& before, uint64_t max_bytes, std::chrono::seconds kept_for);

 private:
  using Clock = std::chrono::steady_clock;
  using AssetPointer = std::shared_ptr<const Asset>;
  struct Kept {
    AssetPointer asset;
    Clock::time_point until;
  };

  std::map<std::string, AssetPointer, std::less<>> assets_;
  std::map<std::string, Kept, std::less<>> kept_;
};

}  // namespace isosplat::server
