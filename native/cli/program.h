#pragma once

#include <CLI/CLI.hpp>

// What the mains of the programs have in common.
namespace isosplat::cli {

/// Signals that end the program remove its incomplete output files before. A file above the size
/// limit gives an error. Call it first.
void handle_signals();

/// Parses the arguments, which runs the chosen subcommand. Returns the exit code: that of --help or
/// of wrong arguments, else `exit_code`, which the subcommand has set. Prints errors in one line.
/// is_silent: prints nothing, as another process prints the same.
int run_program(CLI::App& program, int argc, char** argv, const int& exit_code,
                bool is_silent = false);

}  // namespace isosplat::cli
