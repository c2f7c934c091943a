#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/server.h"

namespace isosplat::cli {

/// The folder with the built page: the one given, else the one that lies where the program was
/// built or installed; empty where there is none.
std::filesystem::path find_page(const std::string& given);

/// Starts a server, prints where it is (with `volume` opened, if it is not empty), and returns
/// when a signal has stopped it. Returns the exit code.
int serve_until_stopped(ServerOptions options, const std::string& volume);

}  // namespace isosplat::cli
