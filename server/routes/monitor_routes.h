#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of the routes for operators.

/// Whether the server can serve at this time: 200 or 503.
Response ready_response(const RouteCall& call);

/// Counters for Prometheus.
Response metrics_response(const RouteCall& call);

}  // namespace isosplat::server
