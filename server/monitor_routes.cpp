#include "server/monitor_routes.h"

#include "server/credentials.h"
#include "server/metrics.h"

namespace isosplat {
namespace {

StoreCounts count_stores(const CatalogSnapshot& catalog) {
  StoreCounts counts;
  for (const auto& [name, entry] : catalog) ++(entry.store ? counts.served : counts.broken);
  return counts;
}

}  // namespace

Response ready_response(const RouteCall& call) {
  const StoreCounts stores = count_stores(*call.catalog);
  const char* reason = nullptr;
  if (call.monitor.is_stopping()) {
    reason = "the server is stopping";
  } else if (stores.served == 0 && stores.broken > 0) {
    reason = "no store can be read";
  }
  if (reason) {
    Response response = error_response(503, "not_ready", reason);
    response.set("Retry-After", "1");
    return response;
  }
  Response response;
  response.set("Content-Type", "application/json");
  response.set("Cache-Control", "no-store");
  response.text = "{\"status\":\"ready\"}\n";
  return response;
}

Response metrics_response(const RouteCall& call) {
  const bool is_local = call.request.is_from_this_machine && !call.request.is_forwarded;
  if (!is_local && !call.grant.admits_to_all()) {
    if (call.is_private) return unauthorized_response();
    return error_response(403, "forbidden_address",
                          "expected a request from the server's own machine, not through a proxy, "
                          "or a token for all volumes");
  }
  Response response;
  response.set("Content-Type", "text/plain; version=0.0.4; charset=utf-8");
  response.set("Cache-Control", "no-store");
  response.text = call.monitor.metrics ? call.monitor.metrics->text(count_stores(*call.catalog))
                                       : std::string();
  return response;
}

}  // namespace isosplat
