#include "native/cli/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include "native/cli/site_source.h"
#include "server/catalog/catalog.h"
#include "server/catalog/scene_json.h"
#include "server/catalog/thumbnail.h"
#include "server/catalog/volume_json.h"
#include "server/http/conditions.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// Elements of index.html that name the catalog. The browser fetches it in parallel to the page's
/// program.
constexpr std::string_view kCatalogElements =
    "<meta name=\"isosplat-catalog\" content=\"catalog.json\">"
    "<link rel=\"preload\" as=\"fetch\" href=\"catalog.json\" crossorigin>";

/// The files of the built page, index.html last.
Result<std::vector<PageFile>> page_files(const fs::path& page) {
  std::vector<PageFile> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(page, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const bool is_hidden = entry->path().filename().string().starts_with('.');
    if (is_hidden && entry->is_directory()) entry.disable_recursion_pending();
    if (is_hidden || !entry->is_regular_file()) continue;
    files.push_back({entry->path(), entry->path().lexically_relative(page)});
  }
  if (error) {
    return fail(Status::io_error,
                fmt::format("{}: expected the folder of the page, cannot read it: {}",
                            page.string(), error.message()));
  }
  const auto index = std::ranges::find(files, fs::path(kIndexFile), &PageFile::relative);
  if (index == files.end()) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected the built page, found no {}: npm run build builds it",
                            page.string(), kIndexFile));
  }
  std::iter_swap(index, files.end() - 1);
  return files;
}

Result<std::string> read_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream)
    return fail(Status::io_error, path.string() + ": cannot read the file: check its permissions");
  return text;
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

/// index.html with the elements that name the catalog.
Result<std::string> site_index(const fs::path& path) {
  auto html = read_text(path);
  if (!html) return html;
  constexpr std::string_view kHead = "<head>";
  const size_t head = html->find(kHead);
  if (head == std::string::npos) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected {}, found none: npm run build builds the page",
                            path.string(), kHead));
  }
  html->insert(head + kHead.size(), kCatalogElements);
  return html;
}

/// The file name of a picture. Different pictures of a store have different names.
std::string picture_file(const std::string& store, std::span<const std::byte> picture) {
  const std::string etag =
      server::etag_for({reinterpret_cast<const char*>(picture.data()), picture.size()});
  const std::string_view hash = std::string_view(etag).substr(1, etag.size() - 2);
  return fmt::format("{}-{}{}", store.substr(0, store.rfind('.')), hash,
                     server::kThumbnailExtension);
}

/// A file to publish, and its description in the catalog.
struct Item {
  SiteFile file;
  uint64_t bytes = 0;
  StoreInfo info;             ///< of a volume
  server::SceneFacts facts;   ///< of a scene
  std::set<fs::path> stores;  ///< of a scene document
};

/// Opens a store or a scene, and looks whether the site has it.
Result<Item> item_of(const server::CatalogEntry& entry, SitePlace& place) {
  const auto source = SiteSource::open(entry.kind, entry.path);
  if (!source) return tl::unexpected(source.error());
  Item item;
  item.stores = source->stores();
  if (const StoreFile* store = source->store()) item.info = store->info();
  item.facts = source->facts();
  item.bytes = source->bytes();
  SiteFile& file = item.file;
  file.kind = entry.kind;
  file.name = entry.name;
  file.path = entry.path;
  file.content = source->content();
  file.file = fmt::format("stores/{}-{}{}", file.name, file.content,
                          source->store() ? server::kStoreExtension : server::kBundleExtension);
  const auto has = place.has(file.file, *source);
  if (!has) return tl::unexpected(has.error());
  file.is_new = !*has;
  if (const auto picture = server::read_thumbnail(file.path, file.content)) {
    file.thumbnail = picture_file(file.file, *picture);
  }
  return item;
}

/// All files to publish: volumes, then scenes.
Result<std::vector<Item>> items_of(const SiteOptions& options) {
  std::string folder_error;
  server::Catalog catalog(options.stores, [&](std::string_view line) {
    if (line.starts_with("folder ")) folder_error = line;
  });
  catalog.scan();
  if (!folder_error.empty()) return fail(Status::io_error, folder_error);
  // The site may be inside a folder that is published. Its own files are published only if they are
  // named.
  const bool are_named = std::ranges::any_of(
      options.stores, [&](const fs::path& source) { return options.place->contains(source); });
  std::vector<Item> items;
  std::set<fs::path> in_scenes;
  for (const auto kind : {server::ServedKind::scene, server::ServedKind::volume}) {
    const auto entries = catalog.snapshot(kind);
    for (const auto& [name, entry] : *entries) {
      if (!are_named && options.place->contains(entry->folder)) continue;
      const bool is_named = std::ranges::find(options.stores, entry->path) != options.stores.end();
      if (!is_named && in_scenes.contains(entry->path.lexically_normal())) continue;
      auto item = item_of(*entry, *options.place);
      if (!item) return tl::unexpected(item.error());
      in_scenes.insert(item->stores.begin(), item->stores.end());
      items.push_back(std::move(*item));
    }
  }
  if (items.empty()) {
    return fail(Status::invalid_argument,
                "expected at least one store or scene, found none: isosplat build makes them");
  }
  std::stable_partition(items.begin(), items.end(), [](const Item& item) {
    return item.file.kind == server::ServedKind::volume;
  });
  return items;
}

/// Copies pictures. Removes the name of one that was removed or replaced meanwhile.
Result<void> copy_thumbnails(std::span<Item> items, SitePlace& place) {
  for (Item& item : items) {
    SiteFile& file = item.file;
    if (file.thumbnail.empty()) continue;
    const auto picture = server::read_thumbnail(file.path, file.content);
    if (!picture || picture_file(file.file, *picture) != file.thumbnail) {
      file.thumbnail.clear();
    } else if (auto written = place.write(file.thumbnail, *picture); !written) {
      return written;
    }
  }
  return {};
}

/// Copies new stores and scenes. Opens each of them again, since there may be more than a program
/// may open at a time.
Result<void> copy_files(std::span<const Item> items, const SiteOptions& options) {
  uint64_t all = 0, done = 0;
  for (const Item& item : items) all += item.file.is_new ? item.bytes : 0;
  for (const auto& [file, bytes, info, facts, stores] : items) {
    if (!file.is_new) continue;
    const auto source = SiteSource::open(file.kind, file.path);
    if (!source) return tl::unexpected(source.error());
    if (source->content() != file.content) {
      return fail(Status::io_error, fmt::format("{}: was replaced while the site was written: "
                                                "publish it again",
                                                file.path.string()));
    }
    auto copied = options.place->copy(file.file, *source, [&](uint64_t more) {
      done += more;
      if (options.progress) options.progress(done, all);
    });
    if (!copied) return copied;
  }
  return {};
}

std::string catalog_json(std::span<const Item> items) {
  std::vector<std::string> volumes, scenes;
  for (const auto& [file, bytes, info, facts, stores] : items) {
    if (file.kind == server::ServedKind::volume) {
      volumes.push_back(server::published_volume_json(
          {file.name, file.content, file.file, info, file.thumbnail}));
    } else {
      scenes.push_back(server::published_scene_json(file.name, file.file, facts, file.thumbnail));
    }
  }
  const std::string listed =
      scenes.empty() ? std::string() : fmt::format(",\"scenes\":[{}]", fmt::join(scenes, ","));
  return fmt::format("{}1\",\"volumes\":[{}]{}}}\n", kCatalogBeginning, fmt::join(volumes, ","),
                     listed);
}

}  // namespace

Result<Site> publish_site(const SiteOptions& options) {
  SitePlace& place = *options.place;
  if (options.prune) {
    if (auto checked = place.check_prune(); !checked) return tl::unexpected(checked.error());
  }
  const auto page = page_files(options.page);
  if (!page) return tl::unexpected(page.error());
  if (auto checked = place.check(*page, options.force); !checked) {
    return tl::unexpected(checked.error());
  }
  const auto index = site_index(page->back().source);
  if (!index) return tl::unexpected(index.error());

  auto items = items_of(options);
  if (!items) return tl::unexpected(items.error());
  std::vector<fs::path> inputs, outputs{kCatalogFile};
  std::set<fs::path> kept;
  for (const PageFile& file : *page) {
    inputs.push_back(file.source);
    outputs.push_back(file.relative);
    kept.insert(file.relative);
  }
  for (const auto& [file, bytes, info, facts, stores] : *items) {
    inputs.push_back(file.path);
    inputs.insert(inputs.end(), stores.begin(), stores.end());
    kept.insert(file.file);
    if (file.is_new) outputs.emplace_back(file.file);
    if (file.thumbnail.empty()) continue;
    outputs.emplace_back(file.thumbnail);
    kept.insert(file.thumbnail);
  }
  // All checks come before the first write.
  for (const fs::path& output : outputs) {
    if (auto checked = place.check_not_input(output, inputs); !checked) {
      return tl::unexpected(checked.error());
    }
  }

  if (auto copied = copy_thumbnails(*items, place); !copied) {
    return tl::unexpected(copied.error());
  }
  if (auto copied = copy_files(*items, options); !copied) return tl::unexpected(copied.error());
  for (const PageFile& file : *page) {
    const bool is_index = file.relative == kIndexFile;
    // The compressed forms of index.html lack the elements that name the catalog.
    if (!is_index && file.relative.string().starts_with(std::string(kIndexFile) + ".")) continue;
    if (!place.wants(file.relative)) continue;
    if (is_index) {
      auto written = place.write(kCatalogFile, bytes_of(catalog_json(*items)));
      if (!written) return tl::unexpected(written.error());
    }
    const auto text = is_index ? index : read_text(file.source);
    if (!text) return tl::unexpected(text.error());
    auto written = place.write(file.relative, bytes_of(*text));
    if (!written) return tl::unexpected(written.error());
  }
  Site site;
  for (Item& item : *items) site.files.push_back(std::move(item.file));
  if (options.prune) {
    auto pruned = place.prune(kept, inputs);
    if (!pruned) return tl::unexpected(pruned.error());
    site.pruned = std::move(*pruned);
  }
  return site;
}

}  // namespace isosplat::cli
