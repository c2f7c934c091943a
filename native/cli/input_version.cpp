#include "native/cli/input_version.h"

#include <fmt/format.h>
#include <sys/stat.h>

namespace isosplat::cli {

std::string input_version(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return "none";
  return fmt::format("{} {}.{:09}", status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
}

}  // namespace isosplat::cli
