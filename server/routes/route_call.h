#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "server/access/access_rules.h"
#include "server/catalog/catalog.h"
#include "server/catalog/scene_pool.h"
#include "server/catalog/store_pool.h"
#include "server/http/message.h"
#include "server/http/target.h"
#include "server/routes/page_assets.h"
#include "server/routes/volume_view.h"
#include "server/routes/work_turn.h"

namespace isosplat::server {

/// Limits of one request. ServerLimits has the same limits, except those of points.
struct RouterLimits {
  uint64_t query_bytes = uint64_t{64} << 20;
  uint32_t query_chunks = 65536;
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  uint64_t query_cells = uint64_t{16} << 20;  ///< of the chunks from which points are computed
  uint64_t query_border_bytes = uint64_t{64} << 20;  ///< PointLimits::border_bytes
  uint32_t query_isovalues = 1024;                   ///< in one table of isovalues
  size_t target_bytes = 8 * 1024;

  ChunkBudget chunk_budget() const { return {query_bytes, query_chunks, query_directory_bytes}; }
};

class ByteBudget;
class ChunkCache;
class Metrics;
class Compressor;

/// The data that the routes for operators report. The pointers must outlive the router.
struct Monitor {
  const Metrics* metrics = nullptr;  ///< null: none are counted
  const std::atomic<bool>* stopping = nullptr;
  const ByteBudget* bytes_in_flight = nullptr;  ///< null as above
  bool is_stopping() const { return stopping && *stopping; }
};

/// Numbers of volumes or scenes, counted at most about a second ago.
struct VolumeCounts {
  uint64_t open_to_all = 0;                     ///< that every client may read
  uint64_t open_to_all_broken = 0;              ///< those of them that cannot be served
  uint64_t served = 0, broken = 0, unread = 0;  ///< of all, by StoreState
};

/// The volume of a request, with its store, which stays open until the response is sent.
struct OpenVolume {
  std::string_view name;
  std::shared_ptr<const StoreFile> store;
};

/// The scene of a request, which stays open until the response is sent.
struct OpenScene {
  std::string_view name;
  std::shared_ptr<const ServedScene> scene;
};

/// The files of one kind that a request can use.
struct ServedFiles {
  std::shared_ptr<const CatalogSnapshot> catalog;
  VolumeViews& views;
  VolumeCounts counts;
};

/// A request and its context, for a route's handler. Valid while the handler runs.
struct RouteCall {
  const Request& request;
  const Target& target;
  const RouterLimits& limits;
  NoWait* no_wait;  ///< for every read of a store; null: may wait
  ThreadKind thread;
  ServedFiles volumes;
  ServedFiles scenes;
  StorePool& stores;
  ScenePool& scene_pool;
  std::shared_ptr<const PageAssets> page;  ///< null: none
  const Grant& grant;                      ///< the rights of the client
  const Monitor& monitor;
  Compressor& compressor;
  ChunkCache& chunks;

  /// Whether the response depends on the client's rights, so that only the client's own cache may
  /// store it. Without a volume: whether there are tokens or links.
  bool is_private = false;

  /// The path's segments for the placeholders {…} of the pattern, in order.
  std::vector<std::string_view> arguments;

  /// For routes with {name}: the volume or the scene, which the client may read.
  std::optional<OpenVolume> volume{};
  std::optional<OpenScene> scene{};

  /// For handlers that read more than a thread for disks should read at once; null: read all.
  WorkTurn* turn = nullptr;

  const ServedFiles& files(ServedKind kind) const {
    return kind == ServedKind::volume ? volumes : scenes;
  }

  /// The volume or the scene of this name if the client may read it, else null. One that it may not
  /// read takes the same time as one that does not exist.
  const CatalogEntry* readable(ServedKind kind, std::string_view name) const;
};

}  // namespace isosplat::server
