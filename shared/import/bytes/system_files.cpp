#include <system_error>
#include <utility>

#include "shared/import/bytes/input_files.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::import {
namespace {

class SystemFile : public InputFile {
 public:
  explicit SystemFile(PosixFile file) : file_(std::move(file)) {}

  Result<size_t> read_some(uint64_t offset, std::span<std::byte> out) const override {
    return file_.read_some(offset, out);
  }

 private:
  PosixFile file_;
};

InputKind kind_of(const std::filesystem::file_status& status) {
  switch (status.type()) {
    case std::filesystem::file_type::regular:
      return InputKind::file;
    case std::filesystem::file_type::directory:
      return InputKind::folder;
    case std::filesystem::file_type::none:
    case std::filesystem::file_type::not_found:
      return InputKind::none;
    default:
      return InputKind::other;
  }
}

}  // namespace

Result<std::unique_ptr<InputFile>> open_input(const std::filesystem::path& path) {
  auto file = PosixFile::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<SystemFile>(std::move(*file));
}

Result<InputState> input_state(const std::filesystem::path& path) {
  const auto identity = file_identity(path);
  if (!identity) return tl::unexpected(identity.error());
  return InputState{identity->bytes, identity->modified_ns};
}

InputKind input_kind(const std::filesystem::path& path) {
  std::error_code error;
  return kind_of(std::filesystem::status(path, error));
}

std::vector<FolderEntry> folder_entries(const std::filesystem::path& folder) {
  std::vector<FolderEntry> entries;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code unknown;
    entries.push_back({entry->path(), kind_of(entry->status(unknown))});
  }
  return entries;
}

}  // namespace isosplat::import
