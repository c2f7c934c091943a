#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "server/catalog/catalog_entries.h"
#include "server/catalog/store_summary.h"

namespace isosplat::server {

/// Keeps the summary of an entry's file. A temporary error is reported, but not kept. `cause`: the
/// error with the whole path, for the log; null: none. Logs what is new: the first summary, an
/// error, another content. Returns whether something is new.
bool keep_summary(const CatalogEntry& entry, const std::shared_ptr<const StoreSummary>& summary,
                  const Error* cause, const std::function<void(std::string_view)>& log);

/// Whether the program can open another file at this moment.
bool has_descriptors();

}  // namespace isosplat::server
