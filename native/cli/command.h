#pragma once

#include <CLI/CLI.hpp>

// One function per subcommand, each in a file of its own. It adds the subcommand with its options
// and examples to the program; when the person has chosen it, it runs and leaves its exit code.
namespace isosplat::cli {

/// What the program ends with.
inline constexpr int kSuccess = 0;
inline constexpr int kFailure = 1;
inline constexpr int kUsage = 2;

void add_build_command(CLI::App& program, int& exit_code);
void add_demo_command(CLI::App& program, int& exit_code);
void add_extract_command(CLI::App& program, int& exit_code);
void add_info_command(CLI::App& program, int& exit_code);
void add_render_command(CLI::App& program, int& exit_code);
void add_serve_command(CLI::App& program, int& exit_code);
void add_verify_command(CLI::App& program, int& exit_code);
void add_view_command(CLI::App& program, int& exit_code);

}  // namespace isosplat::cli
