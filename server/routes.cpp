#include "server/routes.h"

#include <algorithm>
#include <array>

#include "server/content_routes.h"
#include "server/monitor_routes.h"
#include "server/page_route.h"
#include "server/sample_routes.h"
#include "server/volume_routes.h"

namespace isosplat {
namespace {

/// Other paths below /v1 do not fall back to the page.
Response no_such_path(const RouteCall&) {
  return error_response(
      404, status_name(Status::not_found),
      "expected /v1/openapi.json, /v1/volumes, /v1/volumes/{name}, and below a content id header, "
      "pages/{page}, chunks/{level}/{x}.{y}.{z}/{band}, chunks?isovalue=…, "
      "batch?chunks=…, isovalues?isovalue=…, samples?isovalue=…, file or thumbnail.png");
}

constexpr auto kRoutes = std::to_array<Route>({
    {Method::get, "/healthz", health_response},
    {Method::get, "/readyz", ready_response, RouteWork::reads_headers},
    {Method::get, "/metrics", metrics_response},
    {Method::get, "/v1/openapi.json", openapi_response},
    {Method::get, "/v1/volumes", volumes_response, RouteWork::reads_headers},
    {Method::get, "/v1/volumes/{name}", volume_response},
    {Method::get, "/v1/volumes/{name}/bootstrap", bootstrap_response},
    {Method::get, "/v1/volumes/{name}/{content}/header", header_response},
    {Method::get, "/v1/volumes/{name}/{content}/pages/{page}", directory_page_response},
    {Method::get, "/v1/volumes/{name}/{content}/chunks/{level}/{x}.{y}.{z}/{band}", chunk_response},
    {Method::get, "/v1/volumes/{name}/{content}/chunks", chunks_response},
    {Method::get, "/v1/volumes/{name}/{content}/batch", batch_response},
    {Method::get, "/v1/volumes/{name}/{content}/isovalues", isovalues_response},
    {Method::get, "/v1/volumes/{name}/{content}/samples", samples_response, RouteWork::computes},
    {Method::get, "/v1/volumes/{name}/{content}/file", file_response},
    {Method::get, "/v1/volumes/{name}/{content}/thumbnail.png", thumbnail_response},
    {Method::get, "/v1/…", no_such_path},
    {Method::get, "/…", page_response},
});

constexpr std::string_view kAnySegments = "/…";

bool matches(const std::vector<std::string>& path, std::string_view pattern,
             std::vector<std::string_view>& arguments) {
  arguments.clear();
  for (const std::string& segment : path) {
    if (pattern.empty()) return false;
    if (pattern == kAnySegments) return true;
    pattern.remove_prefix(1);  // the "/"
    const std::string_view expected = pattern.substr(0, pattern.find('/'));
    pattern.remove_prefix(expected.size());
    if (expected.starts_with('{')) {
      arguments.push_back(segment);
    } else if (segment != expected) {
      return false;
    }
  }
  return pattern.empty() || pattern == kAnySegments;
}

}  // namespace

std::span<const Route> routes() {
  return kRoutes;
}

size_t index_of(const Route& route) {
  return static_cast<size_t>(&route - kRoutes.data());
}

const Route* find_route(Method method, const Target& target,
                        std::vector<std::string_view>& arguments) {
  if (method == Method::head) method = Method::get;
  const auto found = std::ranges::find_if(kRoutes, [&](const Route& route) {
    return route.method == method && matches(target.segments, route.pattern, arguments);
  });
  return found == kRoutes.end() ? nullptr : &*found;
}

}  // namespace isosplat
