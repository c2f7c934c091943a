#include "server/volume_routes.h"

#include <utility>

#include "server/conditions.h"
#include "server/streams.h"
#include "server/volume_json.h"

namespace isosplat {
namespace {

Response revalidated_json(const Request& request, std::string text) {
  Response response = begin_answer(request, etag_for(text), CachePolicy::revalidated);
  if (is_answered(response)) return response;
  response.set("Content-Type", "application/json");
  response.text = std::move(text);
  return response;
}

}  // namespace

Response health_answer(const RouteCall& call) {
  size_t served = 0;
  for (const auto& [name, entry] : *call.catalog) served += entry.store ? 1 : 0;
  Response response;
  response.set("Content-Type", "application/json");
  response.set("Cache-Control", "no-store");
  response.text = "{\"status\":\"ok\",\"volumes\":" + std::to_string(served) +
                  ",\"broken\":" + std::to_string(call.catalog->size() - served) + "}\n";
  return response;
}

Response volumes_answer(const RouteCall& call) {
  return revalidated_json(call.request, volume_list_json(*call.catalog));
}

Response volume_answer(const RouteCall& call) {
  return revalidated_json(call.request, volume_json(*call.volume));
}

Response bootstrap_answer(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  if (Result<void> unchanged = store->check_unchanged(); !unchanged) {
    return error_response(unchanged.error());
  }
  Response response =
      begin_answer(call.request, "\"" + store->content() + "-opening1\"", CachePolicy::revalidated);
  if (is_answered(response)) return response;
  response.set("Content-Type", "application/octet-stream");
  response.stream = std::make_unique<BootstrapStream>(store);
  return response;
}

}  // namespace isosplat
