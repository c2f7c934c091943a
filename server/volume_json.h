#pragma once

#include <span>
#include <string>

#include "server/catalog.h"

namespace isosplat {

/// The body of /v1/volumes: these stores, in this order; broken stores with their error.
std::string volume_list_json(std::span<const CatalogEntry* const> entries);

/// A volume of a static site.
struct PublishedVolume {
  const CatalogEntry* entry;  ///< with a store
  std::string file;           ///< of the store, relative to the site
};

/// The catalog of a static site: the same as /v1/volumes, but each volume has `file` in place of
/// `url`. Begins with {"isosplat":"site 1".
std::string published_catalog_json(std::span<const PublishedVolume> published);

/// The body of /v1/volumes/{name}. Requires a store.
std::string volume_json(const CatalogEntry& entry);

}  // namespace isosplat
