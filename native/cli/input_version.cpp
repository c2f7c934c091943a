#include "native/cli/input_version.h"

#include <fmt/format.h>
#include <sys/stat.h>

namespace isosplat::cli {

std::string input_versions(std::span<const std::filesystem::path> files) {
  std::string text;
  for (const std::filesystem::path& file : files) {
    struct stat status {};
    const std::string version = ::stat(file.c_str(), &status) != 0
                                    ? "none"
                                    : fmt::format("{} {}.{:09}", status.st_size,
                                                  status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
    text += fmt::format("\n{} {}", file.string(), version);
  }
  return text;
}

}  // namespace isosplat::cli
