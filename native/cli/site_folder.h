#pragma once

#include "native/cli/site_place.h"

namespace isosplat::cli {

/// A site in a folder, which is created if it does not exist.
class SiteFolder final : public SitePlace {
 public:
  explicit SiteFolder(Path folder) : folder_(std::move(folder)) {}

  Result<void> check(std::span<const PageFile> page, bool force) override;
  bool contains(const Path& file) const override;
  Result<void> check_not_input(const Path& output, std::span<const Path> inputs) const override;
  bool wants(const Path&) const override { return true; }
  Result<bool> has(const Path& path, const SiteSource& source) override;
  Result<void> write(const Path& path, std::span<const std::byte> bytes) override;
  Result<void> copy(const Path& path, const SiteSource& source,
                    const std::function<void(uint64_t bytes)>& copied) override;
  Result<void> check_prune() const override { return {}; }
  Result<std::vector<Path>> prune(const std::set<Path>& kept,
                                  std::span<const Path> inputs) override;

 private:
  Path folder_;
};

}  // namespace isosplat::cli
