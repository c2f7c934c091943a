#include "native/builder/source_path.h"

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace isosplat {

std::string source_path_hash(const std::filesystem::path& volume,
                             const std::filesystem::path& store) {
  std::error_code error;
  const auto from = std::filesystem::weakly_canonical(
      store.has_parent_path() ? store.parent_path() : std::filesystem::path("."), error);
  auto to = std::filesystem::weakly_canonical(volume, error);
  if (!to.has_filename()) to = to.parent_path();  // "folder/"
  const std::string relative = to.lexically_relative(from).generic_string();
  return fmt::format("{:016x}", XXH3_64bits(relative.data(), relative.size()));
}

std::string source_file_name(const std::filesystem::path& volume) {
  return (volume.has_filename() ? volume : volume.parent_path()).filename().string();
}

}  // namespace isosplat
