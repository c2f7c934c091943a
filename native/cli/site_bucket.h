#pragma once

#include <memory>
#include <string>

#include "native/cli/remote_flags.h"
#include "native/cli/site_place.h"
#include "native/remote/bucket_upload.h"

namespace isosplat::cli {

/// A site in a bucket: its objects are BUCKET/PREFIX/PATH. Stores, scenes, pictures and assets,
/// whose names change with their content, may be kept by caches for ever; all others are
/// revalidated.
class SiteBucket final : public SitePlace {
 public:
  /// address: s3://BUCKET or s3://BUCKET/PREFIX.
  SiteBucket(std::string address, const RemoteFlags& flags);

  Result<void> check(std::span<const PageFile> page, bool force) override;
  bool contains(const Path&) const override { return false; }
  Result<void> check_not_input(const Path&, std::span<const Path>) const override { return {}; }
  /// Buckets do not choose between encodings of a file.
  bool wants(const Path& page_file) const override;
  Result<bool> has(const Path& path, const SiteSource& source) override;
  Result<void> write(const Path& path, std::span<const std::byte> bytes) override;
  Result<void> copy(const Path& path, const SiteSource& source,
                    const std::function<void(uint64_t bytes)>& copied) override;
  Result<void> check_prune() const override;
  Result<std::vector<Path>> prune(const std::set<Path>& kept,
                                  std::span<const Path> inputs) override;

 private:
  Result<remote::RemoteTarget> target(const Path& path) const;
  /// Whether there is an object that begins with these bytes. Errors: io_error.
  Result<bool> begins_with(const Path& path, std::span<const std::byte> expected);
  Result<void> send(const Path& path, const RandomAccessFile& file, uint64_t bytes,
                    const std::function<void(uint64_t bytes)>& sent);

  std::string address_;
  remote::RemoteOptions options_;
  remote::HttpClient client_;
};

}  // namespace isosplat::cli
