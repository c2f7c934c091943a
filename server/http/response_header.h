#pragma once

#include <string>

#include "server/http/message.h"

namespace isosplat::server {

/// The status line and the fields of a response, with the empty line at the end. `close`: the
/// connection ends after it. `http_1_0`: the version of the request.
std::string response_header(const Response& response, bool close, bool http_1_0);

}  // namespace isosplat::server
