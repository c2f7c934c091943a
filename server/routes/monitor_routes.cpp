#include "server/routes/monitor_routes.h"

#include <cstdint>
#include <memory>
#include <optional>

#include "server/access/credentials.h"
#include "server/routes/metrics.h"
#include "server/routes/summaries.h"

namespace isosplat::server {
namespace {

StoreCounts counts_of(const VolumeCounts& counted) {
  StoreCounts counts;
  counts.served = counted.served;
  counts.broken = counted.broken;
  counts.unread = counted.unread;
  return counts;
}

StoreCounts count_stores(const RouteCall& call) {
  StoreCounts counts = counts_of(call.volumes.counts);
  counts.open = call.stores.size();
  counts.opened = call.stores.opened();
  return counts;
}

StoreCounts count_scenes(const RouteCall& call) {
  StoreCounts counts = counts_of(call.scenes.counts);
  counts.open = call.scene_pool.size();
  return counts;
}

struct ReadyProgress : CatalogProgress {
  using CatalogProgress::CatalogProgress;

  uint32_t tried = 0;
};

/// Whether there are stores, none of which can be read, and no scene was read. If no header has
/// been read so far, reads headers until one is valid or many are invalid. No value if this must
/// wait, or needs another turn.
std::optional<bool> are_all_broken(const RouteCall& call) {
  constexpr uint32_t kTried = 64;
  if (call.volumes.catalog->empty() || call.volumes.counts.served > 0 ||
      call.scenes.counts.served > 0) {
    return false;
  }
  std::unique_ptr<WorkTurn::Progress> own;
  auto& ready = progress_of<ReadyProgress>(call, own);
  Summaries summaries(call);
  for (; ready.next != ready.catalog->end() && ready.tried < kTried; ++ready.next, ++ready.tried) {
    const auto summary = summaries.of(*ready.next->second);
    if (!summary) return std::nullopt;
    if (!summary->error) return false;
  }
  return true;
}

}  // namespace

Response ready_response(const RouteCall& call) {
  const char* reason = nullptr;
  if (call.monitor.is_stopping()) {
    reason = "the server is stopping";
  } else {
    const std::optional<bool> is_broken = are_all_broken(call);
    if (!is_broken) return {};  // the connection calls again where it may wait
    if (*is_broken) reason = "no store can be read";
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
  response.text = call.monitor.metrics
                      ? call.monitor.metrics->text(count_stores(call), count_scenes(call),
                                                   call.monitor.bytes_in_flight)
                      : std::string();
  return response;
}

}  // namespace isosplat::server
