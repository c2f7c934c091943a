#pragma once

#include <CLI/CLI.hpp>

namespace isosplat::cli {

/// Adds the option --config FILE. The file has lines NAME = VALUE with the names of the command's
/// options, without dashes. The command line takes precedence over the file. Add this option before
/// all others: options are processed in the order in which they were added. (CLI11's set_config
/// works only for the whole program, not for a subcommand.)
void add_config_option(CLI::App& command);

}  // namespace isosplat::cli
