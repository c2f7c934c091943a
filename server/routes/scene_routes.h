#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of the routes below /v1/scenes. Every scene is served as a bundle.

Response scenes_response(const RouteCall& call);
Response scene_response(const RouteCall& call);

/// The beginning of the bundle: everything for the first picture (BundleBytes::first_bytes).
Response scene_bootstrap_response(const RouteCall& call);

/// The bundle, or a range of it.
Response scene_file_response(const RouteCall& call);

/// The picture beside the scene's file, if it shows this content.
Response scene_thumbnail_response(const RouteCall& call);

}  // namespace isosplat::server
