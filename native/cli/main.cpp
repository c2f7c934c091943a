#include <fmt/format.h>
#include <isosplat/version.h>

#include <csignal>

#include "native/cli/command.h"
#include "native/files/output_file.h"

namespace {

/// Prints an error of the arguments in one line, like all errors of the program. (CLI11 prints
/// several lines, with the help.)
int usage_error(const CLI::App& program, const CLI::ParseError& error) {
  std::string message = error.what();
  const auto unknown = program.remaining();
  if (program.get_subcommands().empty() && !unknown.empty() && !unknown[0].starts_with('-')) {
    message = "expected a subcommand, found '" + unknown[0] + "'";
  }
  for (char& c : message) {
    if (c == '\n') c = ' ';
  }
  std::string command = "isosplat";
  for (const CLI::App* chosen : program.get_subcommands()) command += " " + chosen->get_name();
  fmt::print(stderr, "isosplat: {}; see {} --help\n", message, command);
  return isosplat::cli::kUsage;
}

/// Removes incomplete output files when a signal ends the program.
extern "C" void end_by_signal(int signal) {
  isosplat::remove_unfinished_files();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

int main(int argc, char** argv) {
  // A file above the size limit (ulimit -f) then gives an error with a message, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  // Signals that the parent ignores stay ignored: nohup ignores SIGHUP, and a shell ignores SIGINT
  // for its background jobs.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU}) {
    if (std::signal(signal, end_by_signal) == SIG_IGN) std::signal(signal, SIG_IGN);
  }

  CLI::App program(
      "Isosplat builds stores from volumes and shows their isosurfaces in a browser, for any "
      "isovalue.",
      "isosplat");
  program.set_version_flag("--version", "isosplat " ISOSPLAT_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Examples:\n"
      "  isosplat view head.nii.gz           show a volume in the browser\n"
      "  isosplat build scan/ -o scan.isosplat\n"
      "                                      build a store from a DICOM folder\n"
      "  isosplat serve stores/              serve all stores of a folder\n"
      "  isosplat COMMAND --help             the options of a command, with examples");

  int exit_code = isosplat::cli::kSuccess;
  isosplat::cli::add_build_command(program, exit_code);
  isosplat::cli::add_join_command(program, exit_code);
  isosplat::cli::add_info_command(program, exit_code);
  isosplat::cli::add_serve_command(program, exit_code);
  isosplat::cli::add_health_command(program, exit_code);
  isosplat::cli::add_view_command(program, exit_code);
  isosplat::cli::add_publish_command(program, exit_code);
  isosplat::cli::add_sign_link_command(program, exit_code);
  isosplat::cli::add_extract_command(program, exit_code);
  isosplat::cli::add_render_command(program, exit_code);
  isosplat::cli::add_verify_command(program, exit_code);
  isosplat::cli::add_bundle_command(program, exit_code);
  isosplat::cli::add_unbundle_command(program, exit_code);
  isosplat::cli::add_demo_command(program, exit_code);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return usage_error(program, error);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "isosplat: out of memory: close other programs, or reduce --memory\n");
    return isosplat::cli::kFailure;
  } catch (const std::exception& error) {
    fmt::print(stderr, "isosplat: {}\n", error.what());
    return isosplat::cli::kFailure;
  }
  return exit_code;
}
