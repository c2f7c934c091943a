#include "server/routes/routes.h"

#include <algorithm>
#include <array>

#include "server/routes/content_routes.h"
#include "server/routes/monitor_routes.h"
#include "server/routes/page_route.h"
#include "server/routes/sample_routes.h"
#include "server/routes/scene_routes.h"
#include "server/routes/volume_routes.h"

namespace isosplat::server {
namespace {

/// Other paths below /v1 do not fall back to the page.
Response no_such_path(const RouteCall&) {
  return error_response(
      404, status_name(Status::not_found),
      "expected /v1/openapi.json, /v1/volumes, /v1/volumes/{name}, and below a content id header, "
      "pages/{page}, chunks/{level}/{x}.{y}.{z}/{band}, chunks?isovalue=…, "
      "batch?chunks=…, isovalues?isovalue=…, samples?isovalue=…, file or thumbnail.webp; or "
      "/v1/scenes, /v1/scenes/{name}, and below a content id file or thumbnail.webp");
}

constexpr std::string_view kText = R"({"type":"string"})";
constexpr std::string_view kIndex = R"({"type":"integer","minimum":0})";

constexpr auto kListParameters = std::to_array<QueryParameter>({
    {"query", false, "words",
     "Words, separated by blanks: each must occur in the name or the title.", kText},
    {"offset", false, "n", "Number of entries to skip.",
     R"({"type":"integer","minimum":0,"default":0})"},
    {"limit", false, "n", "Maximum number of entries to return.",
     R"({"type":"integer","minimum":1,"maximum":1000,"default":100})"},
});

constexpr QueryParameter kOptionalLevel{"level", false, "L", "Level; 0 is the finest.", kIndex};

constexpr auto kChunksParameters = std::to_array<QueryParameter>({
    {"isovalue", true, "a..b", "A number, or a range `a..b`, in the volume's values.", kText,
     R"("60.5")"},
    {"level", true, "L", "Level; 0 is the finest.", kIndex},
    {"blocks", false, "x.y.z,…", "Only these blocks: `x.y.z,x.y.z,…`.", kText},
});

constexpr auto kBatchParameters = std::to_array<QueryParameter>({
    {"chunks", true, "level/x.y.z/band,…", "`level/x.y.z/band,…`.", kText,
     R"("0/1.2.3/4,1/0.0.0/2")"},
});

constexpr auto kIsovaluesParameters = std::to_array<QueryParameter>({
    {"isovalue", true, "a..b or v,v,…", "A number, numbers `v,v,…`, or a range `a..b`.", kText,
     R"("0..255")"},
    {"steps", false, "n", "Number of isovalues of a range, with both ends.",
     R"({"type":"integer","minimum":2,"maximum":1024,"default":64})"},
    kOptionalLevel,
});

constexpr auto kSamplesParameters = std::to_array<QueryParameter>({
    {"isovalue", true, "v", "A number, in the volume's values.", R"({"type":"number"})", "60.5"},
    kOptionalLevel,
    {"box", false, "x0,y0,z0,x1,y1,z1",
     "`x0,y0,z0,x1,y1,z1` in the units of positions: only points in this half-open box.", kText},
    {"fields", false, "positions,normals,values", "Some of `positions`, `normals` and `values`.",
     R"({"type":"string","default":"positions,normals"})"},
    {"field", false, "NAME", "A field of the volume: its value is the last number of each record.",
     kText},
    {"shading", false, "smooth or exact", "Normals: continuous, or the gradient of each cell.",
     R"({"type":"string","enum":["smooth","exact"],"default":"smooth"})"},
    {"format", false, "npy or raw", "A file of NumPy, or only the records.",
     R"({"type":"string","enum":["npy","raw"],"default":"npy"})"},
});

constexpr auto kRoutes = std::to_array<Route>({
    {Method::get, "/healthz", health_response, "health"},
    {Method::get, "/readyz", ready_response, "ready", {}, RouteWork::reads_headers},
    {Method::get, "/metrics", metrics_response, "metrics"},
    {Method::get, "/v1/openapi.json", openapi_response, "openapi"},
    {Method::get, "/v1/volumes", volumes_response, "volumes", kListParameters,
     RouteWork::reads_headers},
    {Method::get, "/v1/volumes/{name}", volume_response, "volume"},
    {Method::get, "/v1/volumes/{name}/bootstrap", bootstrap_response, "bootstrap"},
    {Method::get, "/v1/volumes/{name}/{content}/header", header_response, "header"},
    {Method::get, "/v1/volumes/{name}/{content}/pages/{page}", directory_page_response, "page"},
    {Method::get, "/v1/volumes/{name}/{content}/chunks/{level}/{x}.{y}.{z}/{band}", chunk_response,
     "chunk"},
    {Method::get, "/v1/volumes/{name}/{content}/chunks", chunks_response, "chunks",
     kChunksParameters},
    {Method::get, "/v1/volumes/{name}/{content}/batch", batch_response, "batch", kBatchParameters},
    {Method::get, "/v1/volumes/{name}/{content}/isovalues", isovalues_response, "isovalues",
     kIsovaluesParameters},
    {Method::get, "/v1/volumes/{name}/{content}/samples", samples_response, "samples",
     kSamplesParameters, RouteWork::computes},
    {Method::get, "/v1/volumes/{name}/{content}/file", file_response, "file"},
    {Method::get, "/v1/volumes/{name}/{content}/thumbnail.webp", thumbnail_response, "thumbnail"},
    {Method::get, "/v1/scenes", scenes_response, "scenes", kListParameters,
     RouteWork::reads_headers},
    {Method::get, "/v1/scenes/{name}", scene_response, "scene"},
    {Method::get, "/v1/scenes/{name}/bootstrap", scene_bootstrap_response, "sceneBootstrap"},
    {Method::get, "/v1/scenes/{name}/{content}/file", scene_file_response, "sceneFile"},
    {Method::get, "/v1/scenes/{name}/{content}/thumbnail.webp", scene_thumbnail_response,
     "sceneThumbnail"},
    {Method::get, "/v1/…", no_such_path},
    {Method::get, "/…", page_response},
});

constexpr std::string_view kAnySegments = "/…";

/// The number of segments of each route's pattern, which excludes most routes at once.
constexpr auto kSegments = [] {
  std::array<size_t, kRoutes.size()> counts{};
  std::ranges::transform(kRoutes, counts.begin(), [](const Route& route) {
    return static_cast<size_t>(std::ranges::count(route.pattern, '/'));
  });
  return counts;
}();

bool has_length_of(const Route& route, size_t segments) {
  const size_t own = kSegments[index_of(route)];
  return route.pattern.ends_with(kAnySegments) ? segments + 1 >= own : segments == own;
}

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
    return route.method == method && has_length_of(route, target.segments.size()) &&
           matches(target.segments, route.pattern, arguments);
  });
  return found == kRoutes.end() ? nullptr : &*found;
}

}  // namespace isosplat::server
