#pragma once

#include <string>

#include "server/catalog.h"

namespace isosplat {

/// The body of /v1/volumes: every store, in the order of names, broken ones with their error.
std::string volume_list_json(const CatalogSnapshot& snapshot);

/// The body of /v1/volumes/{name}. Requires a store.
std::string volume_json(const CatalogEntry& entry);

}  // namespace isosplat
