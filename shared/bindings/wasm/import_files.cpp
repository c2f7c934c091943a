#include <string>
#include <string_view>
#include <utility>

#include "shared/bindings/wasm/import_host.h"
#include "shared/import/bytes/input_files.h"

// The files of shared/import in a browser: those that JavaScript offers.
namespace isosplat::import {
namespace {

int32_t find(const std::filesystem::path& path) {
  const std::string text = path.generic_string();
  return isosplat_file_find(text.data(), static_cast<uint32_t>(text.size()));
}

tl::unexpected<Error> not_opened(const std::filesystem::path& path, int32_t found) {
  return fail(Status::io_error, path.string() + (found == ISOSPLAT_FILE_FOLDER
                                                     ? ": expected a file, found a folder"
                                                     : ": cannot be opened: it is not among the "
                                                       "files that were chosen; choose it too"));
}

class HostFile : public InputFile {
 public:
  HostFile(std::string name, int32_t file) : name_(std::move(name)), file_(file) {}

  Result<size_t> read_some(uint64_t offset, std::span<std::byte> out) const override {
    const int32_t got = isosplat_file_read(file_, static_cast<double>(offset), out.data(),
                                           static_cast<uint32_t>(out.size()));
    if (got >= 0) return static_cast<size_t>(got);
    std::string reason(512, '\0');
    reason.resize(isosplat_file_error(reason.data(), static_cast<uint32_t>(reason.size())));
    return fail(Status::io_error, name_ + ": cannot be read: " + reason);
  }

 private:
  std::string name_;
  int32_t file_;
};

}  // namespace

Result<std::unique_ptr<InputFile>> open_input(const std::filesystem::path& path) {
  const int32_t file = find(path);
  if (file < 0) return not_opened(path, file);
  return std::make_unique<HostFile>(path.string(), file);
}

Result<InputState> input_state(const std::filesystem::path& path) {
  const int32_t file = find(path);
  if (file < 0) return not_opened(path, file);
  return InputState{static_cast<uint64_t>(isosplat_file_bytes(file)),
                    static_cast<int64_t>(isosplat_file_modified(file)) * 1'000'000};
}

InputKind input_kind(const std::filesystem::path& path) {
  const int32_t file = find(path);
  if (file == ISOSPLAT_FILE_FOLDER) return InputKind::folder;
  return file < 0 ? InputKind::none : InputKind::file;
}

std::vector<FolderEntry> folder_entries(const std::filesystem::path& folder) {
  const std::string path = folder.generic_string();
  const auto path_bytes = static_cast<uint32_t>(path.size());
  std::string text(isosplat_folder_names(path.data(), path_bytes, nullptr, 0), '\0');
  isosplat_folder_names(path.data(), path_bytes, text.data(), static_cast<uint32_t>(text.size()));
  std::vector<FolderEntry> entries;
  for (std::string_view rest = text; rest.size() > 1;) {
    const size_t end = rest.find('\0');
    const InputKind kind = rest[0] == 'd' ? InputKind::folder : InputKind::file;
    entries.push_back({folder / std::string(rest.substr(1, end - 1)), kind});
    rest.remove_prefix(std::min(end, rest.size() - 1) + 1);
  }
  return entries;
}

}  // namespace isosplat::import
