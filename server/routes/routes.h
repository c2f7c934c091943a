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

/// What the response of a route needs besides what is in memory, and which threads do it.
enum class RouteWork : uint8_t {
  reads,  ///< reads of a store: threads for disks

  /// Headers of many stores, a few in each turn (RouteCall::turn): a part of the threads for disks,
  /// so that these are never all kept by it.
  reads_headers,

  /// Much processor time. On the connection's thread, the handler only says so
  /// (NoWait::needs_disk). It is called again on a thread that computes; if this lacks something of
  /// a disk, on one for disks, where it only reads it, and then again on one that computes. Its
  /// stream is called on these threads alone (BodyStream::fetch).
  computes
};

/// A route. HTTP.md has a table of the same routes in the same order, with their parameters.
struct Route {
  /// HEAD has the route of GET; its body is not sent. The router handles OPTIONS for all paths.
  Method method;

  /// Segments, each after a "/". A segment that begins with "{" matches any text; "…" at the end
  /// matches any number of segments. {name} is a volume with a store; {content} is its content id.
  std::string_view pattern;

  Response (*handler)(const RouteCall&);

  /// Its operation in openapi_parts.json, which begins error messages as well; empty: not a part of
  /// the document, and any query is admitted.
  std::string_view operation{};

  /// All parameters that its query may have. The router checks them before the handler runs.
  std::span<const QueryParameter> parameters{};

  RouteWork work = RouteWork::reads;
};

/// All routes. The first route whose pattern matches a path handles it.
std::span<const Route> routes();

/// Its index in routes(). Requires one of these.
size_t index_of(const Route& route);

/// The route of a path, or null. Sets `arguments` to the segments of its placeholders.
const Route* find_route(Method method, const Target& target,
                        std::vector<std::string_view>& arguments);

}  // namespace isosplat::server
