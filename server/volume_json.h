#pragma once

#include <span>
#include <string>

#include "server/catalog.h"

namespace isosplat {

/// The body of /v1/volumes: these stores, in this order; broken stores with their error.
std::string volume_list_json(std::span<const CatalogEntry* const> entries);

/// The body of /v1/volumes/{name}. Requires a store.
std::string volume_json(const CatalogEntry& entry);

}  // namespace isosplat
