#include "server/routes/route_call.h"

namespace isosplat::server {

const CatalogEntry* RouteCall::readable(ServedKind kind, std::string_view name) const {
  const std::shared_ptr<const CatalogSnapshot>& catalog = files(kind).catalog;
  VolumeIdentity none;
  none.kind = kind;
  auto found = catalog->lower_bound(name);
  const bool exists = found != catalog->end() && found->first == name;
  // If there is no such file, compares the rules with a neighbouring name, to take the same time.
  if (found == catalog->end() && !catalog->empty()) --found;
  const VolumeIdentity& identity =
      catalog->empty() ? none : static_cast<const VolumeIdentity&>(*found->second);
  const bool is_admitted = grant.may_read(name, identity);
  return exists && is_admitted ? found->second.get() : nullptr;
}

}  // namespace isosplat::server
