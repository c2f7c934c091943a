#pragma once

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
  /// `most_bytes`).
  static Result<std::shared_ptr<const PageAssets>> load(const std::filesystem::path& root,
                                                        uint64_t most_bytes, const Log& log);

  /// `path`: decoded, e.g. "/assets/index-x7Hd9aK2.js"; "/" is "/index.html". Null: no such file.
  const Asset* find(std::string_view path) const;

  /// Differs when a file below `root` was added, removed or written to.
  static uint64_t signature(const std::filesystem::path& root);

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

}  // namespace isosplat
