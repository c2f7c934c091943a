#include "server/volume_routes.h"

#include <fmt/format.h>

#include <utility>

#include "server/conditions.h"
#include "server/streams.h"
#include "server/volume_json.h"

namespace isosplat {
namespace {

Response revalidated_json(const Request& request, std::string text) {
  Response response = begin_response(request, etag_for(text), CachePolicy::revalidated);
  if (is_complete(response)) return response;
  response.set("Content-Type", "application/json");
  response.text = std::move(text);
  return response;
}

}  // namespace

Response health_response(const RouteCall& call) {
  size_t served = 0;
  for (const auto& [name, entry] : *call.catalog) served += entry.store ? 1 : 0;
  Response response;
  response.set("Content-Type", "application/json");
  response.set("Cache-Control", "no-store");
  response.text = fmt::format("{{\"status\":\"ok\",\"volumes\":{},\"broken\":{}}}\n", served,
                              call.catalog->size() - served);
  return response;
}

Response volumes_response(const RouteCall& call) {
  return revalidated_json(call.request, volume_list_json(*call.catalog));
}

Response volume_response(const RouteCall& call) {
  return revalidated_json(call.request, volume_json(*call.volume));
}

Response bootstrap_response(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  if (Result<void> unchanged = store->check_unchanged(); !unchanged) {
    return error_response(unchanged.error());
  }
  Response response = begin_response(
      call.request, fmt::format("\"{}-bootstrap1\"", store->content()), CachePolicy::revalidated);
  if (is_complete(response)) return response;
  response.set("Content-Type", "application/octet-stream");
  response.stream = std::make_unique<BootstrapStream>(store);
  return response;
}

}  // namespace isosplat
