#pragma once

#include <string>

#include "server/catalog.h"

namespace isosplat {

/// The body of /v1/volumes: all stores, sorted by name; broken stores with their error.
std::string volume_list_json(const CatalogSnapshot& snapshot);

/// The body of /v1/volumes/{name}. Requires a store.
std::string volume_json(const CatalogEntry& entry);

}  // namespace isosplat
