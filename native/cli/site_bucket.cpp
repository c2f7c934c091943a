#include "native/cli/site_bucket.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "native/files/output_file.h"
#include "server/routes/page_assets.h"

namespace isosplat::cli {
namespace {

constexpr uint64_t kHeaderBytes = uint64_t{64} << 10;  // that are compared

/// Bytes in memory.
class MemoryFile final : public RandomAccessFile {
 public:
  MemoryFile(std::string name, std::span<const std::byte> bytes)
      : name_(std::move(name)), bytes_(bytes) {}

  const std::string& name() const override { return name_; }
  Result<FileIdentity> identity(NoWait*) const override {
    return FileIdentity{.bytes = bytes_.size()};
  }
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait*) const override {
    std::ranges::copy(bytes_.subspan(offset, out.size()), out.begin());
    return {};
  }

 private:
  std::string name_;
  std::span<const std::byte> bytes_;
};

/// The bytes of a store, or of the bundle of a scene.
class SourceFile final : public RandomAccessFile {
 public:
  SourceFile(std::string name, const SiteSource& source)
      : name_(std::move(name)), source_(source) {}

  const std::string& name() const override { return name_; }
  Result<FileIdentity> identity(NoWait*) const override {
    if (auto unchanged = source_.check_unchanged(); !unchanged) {
      return tl::unexpected(unchanged.error());
    }
    return FileIdentity{.bytes = source_.bytes()};
  }
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait*) const override {
    const std::scoped_lock lock(mutex_);
    return source_.read(offset, out);
  }

 private:
  std::string name_;
  const SiteSource& source_;
  mutable std::mutex mutex_;
};

bool is_immutable(const SitePlace::Path& path) {
  const std::string first = path.begin()->string();
  return first == "stores" || first == "assets";
}

}  // namespace

SiteBucket::SiteBucket(std::string address, const RemoteFlags& flags)
    : address_(std::move(address)), options_(flags.options()), client_(options_.http) {
  while (address_.ends_with('/')) address_.pop_back();
}

Result<remote::RemoteTarget> SiteBucket::target(const Path& path) const {
  return remote::target_of(address_ + "/" + path.generic_string(), options_.endpoint);
}

Result<void> SiteBucket::check(std::span<const PageFile> page, bool force) {
  const auto catalog = target(kCatalogFile);
  if (!catalog) return tl::unexpected(catalog.error());
  if (auto checked = remote::check_writable(*catalog); !checked) return checked;
  if (force) return {};
  const auto is_site = begins_with(kCatalogFile, std::as_bytes(std::span(kCatalogBeginning)));
  if (!is_site) return tl::unexpected(is_site.error());
  if (*is_site) return {};
  std::vector<PageFile> files{{{}, kCatalogFile}};
  files.insert(files.end(), page.begin(), page.end());
  for (const auto& [source, relative] : files) {
    if (!wants(relative)) continue;
    const auto object = target(relative);
    if (!object) return tl::unexpected(object.error());
    const auto found = remote::object_bytes(client_, *object);
    if (!found) return tl::unexpected(found.error());
    if (!*found) continue;
    // An interrupted publication has left files of the page.
    const std::string text = first_bytes(source, **found + 1);
    const auto is_same = begins_with(relative, std::as_bytes(std::span(text)));
    if (!is_same) return tl::unexpected(is_same.error());
    if (text.size() == **found && *is_same) continue;
    return fail(Status::invalid_argument,
                fmt::format("{}: expected no {}, or that of a published site, found another "
                            "object: give another prefix with --to, or replace it with --force",
                            address_, relative.generic_string()));
  }
  return {};
}

bool SiteBucket::wants(const Path& page_file) const {
  return page_file.extension() != ".br" && page_file.extension() != ".gz";
}

Result<bool> SiteBucket::begins_with(const Path& path, std::span<const std::byte> expected) {
  const auto object = target(path);
  if (!object) return tl::unexpected(object.error());
  const auto bytes = remote::object_bytes(client_, *object);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!*bytes || **bytes < expected.size()) return false;
  const auto opened = remote::open_remote(object->name, options_);
  if (!opened) return tl::unexpected(opened.error());
  std::vector<std::byte> found(expected.size());
  if (auto read = opened->read(0, found); !read) return tl::unexpected(read.error());
  return std::ranges::equal(found, expected);
}

Result<bool> SiteBucket::has(const Path& path, const SiteSource& source) {
  const auto object = target(path);
  if (!object) return tl::unexpected(object.error());
  const auto bytes = remote::object_bytes(client_, *object);
  if (!bytes) return tl::unexpected(bytes.error());
  if (*bytes != source.bytes()) return false;
  // The header of a store or a bundle has its content id.
  std::vector<std::byte> header(std::min<uint64_t>(kHeaderBytes, source.bytes()));
  if (auto read = source.read(0, header); !read) return tl::unexpected(read.error());
  return begins_with(path, header);
}

Result<void> SiteBucket::send(const Path& path, const RandomAccessFile& file, uint64_t bytes,
                              const std::function<void(uint64_t bytes)>& sent) {
  const auto object = target(path);
  if (!object) return tl::unexpected(object.error());
  remote::UploadOptions options;
  options.content_type = server::mime_type_of(path.generic_string());
  options.cache_control = is_immutable(path) ? "public, max-age=31536000, immutable" : "no-cache";
  options.progress = sent;
  return remote::upload(client_, *object, file, bytes, options);
}

Result<void> SiteBucket::write(const Path& path, std::span<const std::byte> bytes) {
  return send(path, MemoryFile(path.string(), bytes), bytes.size(), {});
}

Result<void> SiteBucket::copy(const Path& path, const SiteSource& source,
                              const std::function<void(uint64_t bytes)>& copied) {
  return send(path, SourceFile(path.string(), source), source.bytes(), copied);
}

Result<void> SiteBucket::check_prune() const {
  return fail(Status::invalid_argument,
              "--prune: expected a folder, found a bucket, whose objects are not listed: remove "
              "old objects with a lifecycle rule, or with the programs of the bucket's host");
}

Result<std::vector<SitePlace::Path>> SiteBucket::prune(const std::set<Path>&,
                                                       std::span<const Path>) {
  return tl::unexpected(check_prune().error());
}

}  // namespace isosplat::cli
