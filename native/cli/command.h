#pragma once

#include <CLI/CLI.hpp>

// One function per subcommand, each in its own file. The function adds the subcommand with its
// options and examples to the program. If the user chose the subcommand, CLI11 runs it after
// parsing, and `exit_code` is set.
namespace isosplat::cli {

/// Exit codes of the program.
inline constexpr int kSuccess = 0;
inline constexpr int kFailure = 1;
inline constexpr int kUsage = 2;  ///< wrong arguments

void add_build_command(CLI::App& program, int& exit_code);
void add_bundle_command(CLI::App& program, int& exit_code);
void add_demo_command(CLI::App& program, int& exit_code);
void add_extract_command(CLI::App& program, int& exit_code);
void add_health_command(CLI::App& program, int& exit_code);
void add_info_command(CLI::App& program, int& exit_code);
void add_join_command(CLI::App& program, int& exit_code);
void add_publish_command(CLI::App& program, int& exit_code);
void add_render_command(CLI::App& program, int& exit_code);
void add_serve_command(CLI::App& program, int& exit_code);
void add_sign_link_command(CLI::App& program, int& exit_code);
void add_unbundle_command(CLI::App& program, int& exit_code);
void add_verify_command(CLI::App& program, int& exit_code);
void add_view_command(CLI::App& program, int& exit_code);

}  // namespace isosplat::cli
