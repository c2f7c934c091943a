#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/server.h"

namespace isosplat::cli {

/// The folder with the built page: `given` unless it is empty, else the page that was built or
/// installed with this program. Empty if there is none.
std::filesystem::path find_page(const std::string& given);

/// Starts a server, prints its URL with this query, and waits until a signal stops it. Returns the
/// exit code.
int serve_until_stopped(server::ServerOptions options, const std::string& query);

}  // namespace isosplat::cli
