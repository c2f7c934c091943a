#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "server/catalog.h"
#include "server/message.h"
#include "server/page_assets.h"
#include "server/target.h"

namespace isosplat {

struct RouterLimits {
  uint64_t query_bytes = uint64_t{64} << 20;
  uint32_t query_chunks = 65536;
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  size_t target_bytes = 8 * 1024;
};

/// A request on its way to a route's handler. Everything lives while the handler runs.
struct RouteCall {
  const Request& request;
  const Target& target;
  const RouterLimits& limits;
  std::shared_ptr<const CatalogSnapshot> catalog;
  std::shared_ptr<const PageAssets> page;  ///< null: none

  /// What the path has for each segment of the pattern that begins with "{", in order.
  std::vector<std::string_view> arguments;

  /// Of routes below {name}: its entry, which has a store.
  const CatalogEntry* volume = nullptr;
};

/// A line of the table: HTTP.md has the same lines in the same order.
struct Route {
  /// HEAD is answered as GET, without the body; OPTIONS by the router, for every path.
  Method method;

  /// Segments, each after a "/". One that begins with "{" stands for any text; "…" at the end
  /// stands for any number of segments. {name} is a volume with a store; {content} is its content
  /// id.
  std::string_view pattern;

  Response (*answer)(const RouteCall&);
};

/// All routes. A path belongs to the first whose pattern it has.
std::span<const Route> routes();

/// The route of the path, whose arguments go into `arguments`; null: none.
const Route* find_route(Method method, const Target& target,
                        std::vector<std::string_view>& arguments);

}  // namespace isosplat
