#pragma once

#include <CLI/CLI.hpp>

namespace isosplat::cli {

/// Adds the option --config FILE: lines NAME = VALUE with the names of the command's options,
/// without dashes. What the command line gives replaces what the file gives. Add it before all
/// other options: options are processed in the order in which they were added. (CLI11's own
/// set_config is for the whole program only, not for a subcommand.)
void add_config_option(CLI::App& command);

}  // namespace isosplat::cli
