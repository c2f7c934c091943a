#include "native/cli/program.h"

#include <fmt/format.h>

#include <csignal>

#include "native/cli/command.h"
#include "native/files/output_file.h"

namespace isosplat::cli {
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
  std::string command = program.get_name();
  for (const CLI::App* chosen : program.get_subcommands()) command += " " + chosen->get_name();
  fmt::print(stderr, "{}: {}; see {} --help\n", program.get_name(), message, command);
  return kUsage;
}

/// Removes incomplete output files when a signal ends the program.
extern "C" void end_by_signal(int signal) {
  remove_unfinished_files();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void handle_signals() {
  // A file above the size limit (ulimit -f) then gives an error with a message, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  // Signals that the parent ignores stay ignored: nohup ignores SIGHUP, and a shell ignores SIGINT
  // for its background jobs.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU}) {
    if (std::signal(signal, end_by_signal) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

int run_program(CLI::App& program, int argc, char** argv, const int& exit_code, bool is_silent) {
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (is_silent) return error.get_exit_code() == 0 ? kSuccess : kUsage;
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return usage_error(program, error);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "{}: out of memory: close other programs, or reduce --memory\n",
               program.get_name());
    return kFailure;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", program.get_name(), error.what());
    return kFailure;
  }
  return exit_code;
}

}  // namespace isosplat::cli
