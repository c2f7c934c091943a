#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "server/http/message.h"
#include "server/http/query_parameters.h"
#include "server/http/target.h"
#include "server/routes/route_call.h"

namespace isosplat::server {

/// The slow work that a route's response needs, and the threads that do it.
enum class RouteWork : uint8_t {
  reads,  ///< reads of a store, on threads for disks

  /// Reads of headers of many stores, a few in each turn (RouteCall::turn). Only a part of the
  /// threads for disks does this work, so that it never occupies all of them.
  reads_headers,

  /// Much processor time. On the connection's thread, the handler only reports this
  /// (NoWait::needs_disk), and is called again on a computing thread. If it lacks bytes there, it
  /// is called on a thread for disks, where it only reads them, and then again on a computing
  /// thread. Its stream is called on these threads alone (BodyStream::fetch).
  computes
};

/// A route. HTTP.md has a table of the same routes in the same order, with their parameters.
struct Route {
  /// HEAD uses the route of GET; its body is not sent. The router handles OPTIONS for all paths.
  Method method;

  /// Segments, each after a "/". A segment that begins with "{" matches any text; "…" at the end
  /// matches any number of segments. {name} is a volume or a scene, {content} its content id.
  std::string_view pattern;

  Response (*handler)(const RouteCall&);

  /// The name of its operation in openapi_parts.json; error messages begin with it as well. Empty:
  /// the route is not in the document, and accepts any query.
  std::string_view operation{};

  /// All parameters that its query may have. The router checks them before the handler runs.
  std::span<const QueryParameter> parameters{};

  RouteWork work = RouteWork::reads;

  /// Whether {name} is the name of a volume or of a scene.
  ServedKind kind() const {
    return pattern.starts_with("/v1/scenes") ? ServedKind::scene : ServedKind::volume;
  }
};

/// All routes. The first route whose pattern matches a path handles it.
std::span<const Route> routes();

/// The index of this route in routes(). Requires a route of that list.
size_t index_of(const Route& route);

/// The route of a path, or null. Sets `arguments` to the segments of its placeholders.
const Route* find_route(Method method, const Target& target,
                        std::vector<std::string_view>& arguments);

}  // namespace isosplat::server
