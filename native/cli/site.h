#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "native/cli/site_place.h"
#include "server/catalog/volume_names.h"
#include "shared/core/base/status.h"

namespace isosplat::cli {

/// A static web site: the page, a catalog, stores, and scenes as bundles. Elements in the page's
/// index.html name the catalog. The page reads stores and bundles by byte ranges, so the site needs
/// no server program.
///
///     index.html, assets/…                      the page
///     catalog.json                              {"isosplat":"site 1","volumes":[…],"scenes":[…]}
///     stores/{name}-{contentId}.isosplat        never changes: another store has another name
///     stores/{name}-{contentId}.isobundle       a scene; never changes either
///     stores/{name}-{contentId}-{hash}.png      its thumbnail, if it has one; never changes either
struct SiteOptions {
  /// Files of stores and scenes, and folders of these. Stores that a scene document names are
  /// published in its bundle alone, unless they are listed here.
  std::vector<std::filesystem::path> stores;
  std::filesystem::path page;  ///< the built page
  SitePlace* place = nullptr;  ///< where the site is written; not null
  bool force = false;          ///< `place` may have other files than a site, and they are replaced
  bool prune = false;          ///< removes stores, bundles and assets that the site no longer uses

  /// Called while stores are copied, with the bytes so far and the total.
  std::function<void(uint64_t done, uint64_t all)> progress;
};

struct SiteFile {
  server::ServedKind kind = server::ServedKind::volume;
  std::string name;
  std::filesystem::path path;  ///< of the source
  std::string file;            ///< relative to the site
  std::string content;         ///< hexadecimal content id
  std::string thumbnail;       ///< relative to the site; empty: none
  bool is_new = false;         ///< whether it was copied now; false: the site had it already
};

struct Site {
  std::vector<SiteFile> files;  ///< volumes, then scenes
  std::vector<std::filesystem::path> pruned;
};

/// Writes or updates a site. Stores are copied first and index.html is written last, so that
/// visitors see either the old site or the new one. If a store or a scene cannot be read, nothing
/// is written. Never overwrites a store, a scene or a file of the page that it reads. Errors: those
/// of SiteSource::open; invalid_argument (no store and no scene, `to` is neither empty nor a site,
/// an output is an input, or the page is not one); io_error.
Result<Site> publish_site(const SiteOptions& options);

}  // namespace isosplat::cli
