#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

/// A file of the page. If the query of an HTML file names a volume, the response makes the browser
/// preload the volume's bootstrap in parallel to the files of the page.
Response page_response(const RouteCall& call);

}  // namespace isosplat::server
