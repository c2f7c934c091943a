#include "server/catalog.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace isosplat {
namespace {

constexpr std::string_view kExtension = ".isosplat";

/// Limit of stores, which bounds the work of a scan.
constexpr size_t kMaxStores = 10'000;

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

/// Replaces the path by the file's name: clients may read the message, and must not see folders.
Error with_file_name(Error error, const std::filesystem::path& path) {
  const std::string full = path.string(), name = path.filename().string();
  size_t at = 0;
  while (full != name && (at = error.message.find(full, at)) != std::string::npos) {
    error.message.replace(at, full.size(), name);
    at += name.size();
  }
  return error;
}

}  // namespace

std::string url_name(const std::filesystem::path& path) {
  constexpr size_t kMaxLength = 128;
  const std::string file = path.filename().string();
  std::string_view stem = file;
  if (stem.ends_with(kExtension)) stem.remove_suffix(kExtension.size());
  std::string name;
  for (const char c : stem) {
    if (is_name_character(c)) {
      name += c;
    } else if (!name.ends_with('-')) {
      name += '-';
    }
  }
  name.erase(0, std::min(name.find_first_not_of("-."), name.size()));
  name.resize(std::min(name.size(), kMaxLength));
  while (name.ends_with('-') || name.ends_with('.')) name.pop_back();
  return name.empty() ? "volume" : name;
}

Catalog::Catalog(std::vector<std::filesystem::path> sources, uint64_t directory_bytes, Log log)
    : sources_(std::move(sources)),
      directory_bytes_(directory_bytes),
      log_(std::move(log)),
      snapshot_(std::make_shared<CatalogSnapshot>()) {}

std::shared_ptr<const CatalogSnapshot> Catalog::snapshot() const {
  const std::lock_guard lock(snapshot_mutex_);
  return snapshot_;
}

std::string Catalog::name_for(const std::filesystem::path& path) {
  const auto known = names_.find(path);
  if (known != names_.end()) return known->second;
  const std::string base = url_name(path);
  std::string name = base;
  for (uint32_t i = 2; !used_names_.insert(name).second; ++i) name = fmt::format("{}-{}", base, i);
  names_.emplace(path, name);
  return name;
}

CatalogEntry Catalog::examine(const std::filesystem::path& path, const CatalogSnapshot& before) {
  CatalogEntry entry;
  entry.name = name_for(path);
  entry.path = path;
  std::error_code ignored;
  entry.folder = std::filesystem::weakly_canonical(
      std::filesystem::absolute(path, ignored).parent_path(), ignored);
  const Result<FileIdentity> identity = file_identity(path);
  if (identity) entry.identity = *identity;

  const auto old = before.find(entry.name);
  if (old != before.end() && old->second.identity == entry.identity &&
      (identity || old->second.error)) {
    return old->second;
  }
  if (auto store = StoreFile::open(path, directory_bytes_)) {
    entry.store = std::move(*store);
  } else {
    entry.error = with_file_name(store.error(), path);
    log_(fmt::format("volume {} is not served: {}", entry.name, store.error().message));
    return entry;
  }
  log_(fmt::format("volume {}: {}, content {}", entry.name, path.string(), entry.store->content()));
  return entry;
}

void Catalog::scan() {
  const std::lock_guard scan_lock(scan_mutex_);
  const std::shared_ptr<const CatalogSnapshot> before = snapshot();

  // Sorted, so that names do not depend on the order in which a folder lists its files.
  std::set<std::filesystem::path> paths;
  for (const std::filesystem::path& source : sources_) {
    std::error_code error;
    if (!std::filesystem::is_directory(source, error)) {
      paths.insert(source);
      continue;
    }
    std::filesystem::directory_iterator file(source, error);
    for (; !error && file != std::filesystem::directory_iterator() && paths.size() < kMaxStores;
         file.increment(error)) {
      const std::filesystem::path& path = file->path();
      const std::string name = path.filename().string();
      if (name.ends_with(kExtension) && !name.starts_with('.')) paths.insert(path);
    }
    std::string& last_error = folder_errors_[source];
    const std::string message = error ? error.message() : "";
    if (message != last_error && error) {
      log_(fmt::format("folder {}: {}", source.string(), message));
    }
    last_error = message;
  }

  auto after = std::make_shared<CatalogSnapshot>();
  for (const std::filesystem::path& path : paths) {
    CatalogEntry entry = examine(path, *before);
    after->emplace(entry.name, std::move(entry));
  }
  for (const auto& [name, entry] : *before) {
    if (!after->contains(name)) {
      log_(fmt::format("volume {} was removed: {}", name, entry.path.string()));
    }
  }
  const std::lock_guard lock(snapshot_mutex_);
  snapshot_ = std::move(after);
}

}  // namespace isosplat
