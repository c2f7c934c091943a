#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "server/catalog/isovalue_needs.h"
#include "server/catalog/store_summary.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// Converts the letters A to Z to lower case, and keeps all others.
std::string small_letters(std::string_view text);

/// The summary of a store for lists.
StoreSummary summary_of(const std::string& name, const StoreFile& store);

/// The same for a store that cannot be served. `error`: without the names of folders.
StoreSummary summary_of(const std::string& name, Error error);

/// A volume of a static site.
struct PublishedVolume {
  std::string name;
  std::string content;  ///< hexadecimal content id
  std::string file;     ///< of the store, relative to the site
  StoreInfo info;
  std::string thumbnail = {};  ///< file of the picture, relative to the site; empty: none
};

/// A volume in the catalog of a static site. It equals that in /v1/volumes, but has `file` in place
/// of `url`, and the file of its picture as `thumbnail`.
std::string published_volume_json(const PublishedVolume& volume);

/// The body of /v1/volumes/{name}.
std::string volume_json(std::string_view name, const StoreFile& store);

/// The body of …/isovalues.
std::string isovalues_json(const StoreInfo& info, uint32_t level,
                           std::span<const IsovalueNeeds> isovalues);

}  // namespace isosplat::server
