#include "native/cli/upload_folder.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <system_error>
#include <utility>

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "isosplat-upload-";
constexpr std::string_view kKeptPrefix = "isosplat-kept-";
constexpr std::string_view kPattern = "XXXXXX";  // of mkdtemp()

/// Opens and locks a folder of this user. Not open if it has another owner, or is locked.
PosixFile lock_folder(const fs::path& folder) {
  PosixFile file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW),
                 folder.string());
  struct stat found {};
  if (file.is_open() && (::fstat(file.descriptor(), &found) != 0 || found.st_uid != ::geteuid() ||
                         ::flock(file.descriptor(), LOCK_EX | LOCK_NB) != 0)) {
    file.close();
  }
  return file;
}

/// Removes folders that no running program has locked.
void remove_stale(const fs::path& parent) {
  std::error_code ignored;
  fs::directory_iterator entry(parent, ignored);
  for (; !ignored && entry != fs::directory_iterator(); entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(kPrefix) || name.size() != kPrefix.size() + kPattern.size()) continue;
    const PosixFile lock = lock_folder(entry->path());
    std::error_code left;
    if (lock.is_open()) fs::remove_all(entry->path(), left);
  }
}

}  // namespace

Result<UploadFolder> UploadFolder::create(fs::path parent) {
  std::error_code error;
  if (parent.empty()) parent = fs::temp_directory_path(error);
  if (!error) remove_stale(parent);
  // Another program may remove the folder as stale before it is locked. In this case, make another
  // one.
  for (int attempt = 0; attempt < 8 && !error; ++attempt) {
    std::string name = (parent / fmt::format("{}{}", kPrefix, kPattern)).string();
    if (!::mkdtemp(name.data())) break;
    UploadFolder folder;
    folder.lock_ = lock_folder(name);
    if (!folder.lock_.is_open() || !fs::exists(name, error)) continue;
    folder.path_ = std::move(name);
    return folder;
  }
  return fail(Status::io_error,
              fmt::format("{}: cannot make a folder for the file before it is uploaded: give "
                          "another folder with --temporary-folder",
                          parent.string()));
}

UploadFolder::UploadFolder(UploadFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), lock_(std::move(other.lock_)) {}

UploadFolder& UploadFolder::operator=(UploadFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(lock_, other.lock_);
  return *this;
}

UploadFolder::~UploadFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

fs::path UploadFolder::keep() {
  const fs::path path = std::exchange(path_, {});
  const std::string name = path.filename().string();
  const fs::path kept =
      path.parent_path() / fmt::format("{}{}", kKeptPrefix, name.substr(kPrefix.size()));
  std::error_code error;
  fs::rename(path, kept, error);
  return error ? path : kept;
}

}  // namespace isosplat::cli
