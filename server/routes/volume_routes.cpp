#include "server/routes/volume_routes.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "server/access/credentials.h"
#include "server/catalog/volume_json.h"
#include "server/http/conditions.h"
#include "server/http/streams.h"
#include "server/routes/json_response.h"
#include "server/routes/openapi_document.h"
#include "server/routes/volume_list.h"

namespace isosplat::server {
Response health_response(const RouteCall& call) {
  // Uses counts from earlier, so that this request never waits, whatever its client and its
  // frequency.
  const uint64_t broken = call.volumes.counts.open_to_all_broken;
  const uint64_t served = call.volumes.counts.open_to_all - broken;
  Response response;
  response.set("Content-Type", "application/json");
  response.set("Cache-Control", "no-store");
  response.text =
      fmt::format("{{\"status\":\"ok\",\"volumes\":{},\"broken\":{}}}\n", served, broken);
  return response;
}

Response openapi_response(const RouteCall& call) {
  static const std::string etag = etag_for(openapi_document());
  return json_response(call, openapi_document(), etag, CachePolicy::revalidated);
}

Response list_response(const RouteCall& call, ServedKind kind) {
  if (!call.grant.is_known() && !call.grant.has_public_volumes()) return unauthorized_response();
  const Result<ListQuery> query = parse_list_query(call.target);
  if (!query) return error_response(query.error());
  std::optional<std::string> list = list_files(call, kind, *query);
  if (!list) return {};  // the connection calls again where it may wait
  return json_response(call, std::move(*list));
}

Response volumes_response(const RouteCall& call) {
  return list_response(call, ServedKind::volume);
}

Response volume_response(const RouteCall& call) {
  // The titles and units of fields are in their headers.
  if (call.no_wait && !call.volume->store->info().fields.empty()) {
    call.no_wait->needs_disk = true;
    return {};
  }
  return json_response(call, volume_json(call.volume->name, *call.volume->store));
}

Response bootstrap_response(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  if (Result<void> unchanged = store->check_unchanged(call.no_wait); !unchanged) {
    return error_response(unchanged.error());
  }
  Response response =
      begin_response(call.request, fmt::format("\"{}-bootstrap1\"", store->content()),
                     CachePolicy::revalidated, call.is_private);
  if (is_complete(response)) return response;
  response.set("Content-Type", "application/octet-stream");
  response.stream = std::make_unique<BootstrapStream>(store);
  return response;
}

}  // namespace isosplat::server
