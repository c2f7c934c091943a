#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace isosplat::test {

/// A folder that is removed with its content when the test ends.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "isosplat-test-XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    path_ = name;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  /// The names of the files in the folder, hidden ones too.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::filesystem::path path_;
};

inline void write_file(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

/// The bytes of a vector of numbers, in the byte order of this machine.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// The folder of the real volumes; nothing if it does not exist.
inline std::optional<std::filesystem::path> volumes_folder() {
  const char* named = std::getenv("ISOSPLAT_VOLUMES");
  const std::filesystem::path folder =
      named ? std::filesystem::path(named)
            : std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "../shared/volumes";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return std::nullopt;
  return folder;
}

}  // namespace isosplat::test

/// Skips the test if the real volumes are absent; otherwise defines `name` as their folder.
#define ISOSPLAT_NEEDS_VOLUMES(name)                                                          \
  const auto name##_found = isosplat::test::volumes_folder();                                 \
  if (!name##_found) {                                                                        \
    GTEST_SKIP() << "needs the real volumes in ../shared/volumes, or where ISOSPLAT_VOLUMES " \
                    "points to";                                                              \
  }                                                                                           \
  const std::filesystem::path name = *name##_found
