#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::cli {

/// A static web site: the page, a catalog, and stores. Elements in the page's index.html name the
/// catalog. The page reads the stores by byte ranges, so the site needs no server program.
///
///     index.html, assets/…                      the page
///     catalog.json                              {"isosplat":"site 1","volumes":[…]}
///     stores/{name}-{contentId}.isosplat        never changes: another store has another name
///     stores/{name}-{contentId}-{hash}.png      its thumbnail, if it has one; never changes either
struct SiteOptions {
  std::vector<std::filesystem::path> stores;  ///< store files, and folders of stores
  std::filesystem::path page;                 ///< the built page
  std::filesystem::path to;                   ///< the folder of the site; created if missing
  bool force = false;  ///< `to` may be a folder that is not a site, and other files are replaced
  bool prune = false;  ///< removes stores and assets in `to` that the site no longer uses

  /// Called while stores are copied, with the bytes so far and the total.
  std::function<void(uint64_t done, uint64_t all)> progress;
};

struct SiteVolume {
  std::string name;
  std::filesystem::path path;  ///< of the source
  std::string file;            ///< relative to the site
  bool is_new = false;         ///< whether it was copied now; false: the site had it already
};

struct Site {
  std::vector<SiteVolume> volumes;
  std::vector<std::filesystem::path> pruned;
};

/// Writes or updates a site. Stores are copied first and index.html is written last, so that
/// visitors see either the old site or the new one. If a store cannot be read, nothing is written.
/// Never overwrites a store or a file of the page that it reads. Errors: those of StoreFile::open;
/// invalid_argument (no store, `to` is neither empty nor a site, an output is an input, or the page
/// is not one); io_error.
Result<Site> publish_site(const SiteOptions& options);

}  // namespace isosplat::cli
