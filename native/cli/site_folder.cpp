#include "native/cli/site_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "native/cli/outputs.h"
#include "native/files/output_file.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

Result<void> create_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return {};
  return fail(Status::io_error,
              fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
}

}  // namespace

Result<void> SiteFolder::check(std::span<const PageFile>, bool force) {
  std::error_code error;
  if (!fs::exists(folder_, error)) return {};
  if (!fs::is_directory(folder_, error)) {
    return fail(Status::invalid_argument, fmt::format("{}: expected a folder for the site, found a "
                                                      "file: give another name with --to",
                                                      folder_.string()));
  }
  const bool is_site =
      first_bytes(folder_ / kCatalogFile, kCatalogBeginning.size()) == kCatalogBeginning;
  if (force || fs::is_empty(folder_, error) || is_site) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected no folder, an empty one, or a published site, found other "
                          "files: give another name with --to, or write into it with --force",
                          folder_.string()));
}

bool SiteFolder::contains(const Path& file) const {
  std::error_code ignored;
  const auto real = [&](const fs::path& given) {
    return fs::weakly_canonical(fs::absolute(given, ignored), ignored);
  };
  const fs::path relative = real(file).lexically_relative(real(folder_));
  return !relative.empty() && *relative.begin() != "..";
}

Result<void> SiteFolder::check_not_input(const Path& output, std::span<const Path> inputs) const {
  return cli::check_not_input(folder_ / output, inputs);
}

Result<bool> SiteFolder::has(const Path& path, const SiteSource& source) {
  const auto kind = source.store() ? server::ServedKind::volume : server::ServedKind::scene;
  const auto found = SiteSource::open(kind, folder_ / path);
  return found && found->content() == source.content();
}

Result<void> SiteFolder::write(const Path& path, std::span<const std::byte> bytes) {
  const Path file = folder_ / path;
  if (auto made = create_folders(file.parent_path()); !made) return made;
  return write_whole_file(file, bytes);
}

Result<void> SiteFolder::copy(const Path& path, const SiteSource& source,
                              const std::function<void(uint64_t bytes)>& copied) {
  constexpr uint64_t kPiece = uint64_t{1} << 20;
  if (auto made = create_folders((folder_ / path).parent_path()); !made) return made;
  auto file = OutputFile::create(folder_ / path);
  if (!file) return tl::unexpected(file.error());
  std::vector<std::byte> piece;
  for (uint64_t offset = 0; offset < source.bytes(); offset += piece.size()) {
    piece.resize(std::min(kPiece, source.bytes() - offset));
    if (auto done = source.read(offset, piece); !done) return done;
    if (auto written = file->write(offset, piece); !written) return written;
    copied(piece.size());
  }
  if (auto unchanged = source.check_unchanged(); !unchanged) return unchanged;
  return file->publish();
}

Result<std::vector<SitePlace::Path>> SiteFolder::prune(const std::set<Path>& kept,
                                                       std::span<const Path> inputs) {
  std::vector<Path> unused;
  for (const char* name : {"assets", "stores"}) {
    std::error_code error;
    for (fs::directory_iterator entry(folder_ / name, error);
         !error && entry != fs::directory_iterator(); entry.increment(error)) {
      const fs::path relative = entry->path().lexically_relative(folder_);
      if (entry->is_regular_file() && !kept.contains(relative) &&
          cli::check_not_input(entry->path(), inputs)) {
        unused.push_back(entry->path());
      }
    }
  }
  for (const Path& path : unused) {
    std::error_code error;
    fs::remove(path, error);
    if (error) {
      return fail(Status::io_error,
                  fmt::format("{}: cannot be removed: {}", path.string(), error.message()));
    }
  }
  return unused;
}

}  // namespace isosplat::cli
