#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of the routes for those who operate the server.

/// Whether the server can serve now: 200 or 503.
Response ready_response(const RouteCall& call);

/// Counters for Prometheus.
Response metrics_response(const RouteCall& call);

}  // namespace isosplat::server
