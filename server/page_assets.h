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

#include "server/conditions.h"
#include "shared/base/status.h"

namespace isosplat {

/// One file of the page in one encoding.
struct AssetVariant {
  Encoding encoding = Encoding::identity;
  std::string bytes;
  std::string etag;  ///< with its quotes; strong, differs between encodings
};

struct Asset {
  std::string_view mime_type;
  bool immutable = false;              ///< the name holds a hash of the content
  std::vector<AssetVariant> variants;  ///< ascending in size; one is identity
};

/// The built page, held in memory. What is not a regular file inside the folder (after resolving
/// links) is not part of it, so no request can reach outside.
class PageAssets {
 public:
  using Log = std::function<void(std::string_view)>;

  /// Reads every file below `root`. Files F.br and F.gz beside F are F's encodings; where there is
  /// no F.gz, text and WASM are compressed here. Errors: io_error, invalid_argument (more than
  /// `max_bytes`).
  static Result<std::shared_ptr<PageAssets>> load(const std::filesystem::path& root,
                                                  uint64_t max_bytes, const Log& log);

  /// `path`: decoded, e.g. "/assets/index-x7Hd9aK2.js"; "/" is "/index.html". Null: no such file.
  const Asset* find(std::string_view path) const;

  /// Differs when a file below `root` was added, removed or written to.
  static uint64_t signature(const std::filesystem::path& root);

  /// Names, as in "/assets/index-x7Hd9aK2.js", that an HTML file here asks for and that are not
  /// here: while a build writes the page, or where its copy is incomplete.
  std::vector<std::string> missing() const;

  /// Goes on to hand out what has a hashed name in `before` and is not here any more, for whoever
  /// has loaded that page and has yet to load parts of it: for `kept_for` from now on, and beyond
  /// it until the page changes again. What `before` has kept stays for the rest of its time. At
  /// most `max_bytes`, the latest first.
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

}  // namespace isosplat
