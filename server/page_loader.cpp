#include "server/page_loader.h"

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isosplat::server {
namespace {

/// How long files of the old page are served after a rebuild, for browsers that have the old page
/// open.
constexpr std::chrono::hours kOldPageKept{1};

}  // namespace

PageLoader::PageLoader(std::filesystem::path root, uint64_t max_bytes, Router& router,
                       ServerLog& log)
    : root_(std::move(root)), max_bytes_(max_bytes), router_(router), log_(log) {}

Result<void> PageLoader::load() {
  if (root_.empty()) return {};
  signature_ = seen_ = PageAssets::signature(root_);
  auto loaded =
      PageAssets::load(root_, max_bytes_, [this](std::string_view line) { log_.line(line); });
  if (!loaded) return tl::unexpected(loaded.error());
  if (const std::vector<std::string> missing = (*loaded)->missing(); !missing.empty()) {
    const std::string text = fmt::format("page {}: its HTML refers to {}, which does not exist",
                                         root_.string(), missing.front());
    if (page_) return fail(Status::io_error, text + ": the old page is served until it does");
    log_.line(text + ": build the page again");
  }
  if (page_) (*loaded)->keep_hashed(*page_, max_bytes_, kOldPageKept);
  page_ = *loaded;
  router_.set_page(page_);
  return {};
}

void PageLoader::load_if_changed() {
  if (root_.empty()) return;
  const uint64_t signature = PageAssets::signature(root_);
  const bool is_stable = signature == seen_;
  seen_ = signature;
  if (!is_stable || signature == signature_) return;
  const Result<void> loaded = load();
  log_.line(loaded ? fmt::format("page: loaded again from {}", root_.string())
                   : loaded.error().message);
}

}  // namespace isosplat::server
