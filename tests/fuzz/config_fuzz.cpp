// A file of options for --config. Whatever it contains, the program starts or reports an error.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "native/cli/config_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const int file = memfd_create("config", 0);
  if (file < 0 || ftruncate(file, 0) != 0) std::abort();
  if (pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) std::abort();

  CLI::App program("", "isosplat");
  CLI::App* command = program.add_subcommand("serve");
  isosplat::cli::add_config_option(*command);
  // One option of each kind that `isosplat serve` has.
  std::vector<std::string> stores, hosts;
  std::string name;
  uint32_t threads = 0;
  double rate = 0;
  bool is_public = false, is_verbose = false;
  command->add_option("stores", stores);
  command->add_option("--allow-host", hosts);
  command->add_option("--token-file", name);
  command->add_option("--threads", threads);
  command->add_option("--rate-requests", rate);
  command->add_flag("--public", is_public);
  command->add_flag("-v,--verbose", is_verbose);
  try {
    program.parse("serve --config /proc/self/fd/" + std::to_string(file) + " --threads 3");
    // The command line has precedence.
    if (threads != 3) std::abort();
  } catch (const CLI::ParseError& error) {
    if (std::string(error.what()).empty()) std::abort();
  }
  return 0;
}
