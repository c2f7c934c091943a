#include "native/cli/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include "native/cli/outputs.h"
#include "native/files/output_file.h"
#include "server/catalog/catalog.h"
#include "server/catalog/thumbnail.h"
#include "server/catalog/volume_json.h"
#include "server/http/conditions.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCatalogFile = "catalog.json";
constexpr const char* kIndexFile = "index.html";
constexpr std::string_view kCatalogBeginning = "{\"isosplat\":\"site ";

/// Elements of index.html that name the catalog. The browser fetches it in parallel to the page's
/// program.
constexpr std::string_view kCatalogElements =
    "<meta name=\"isosplat-catalog\" content=\"catalog.json\">"
    "<link rel=\"preload\" as=\"fetch\" href=\"catalog.json\" crossorigin>";

struct PageFile {
  fs::path source, relative;
};

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

Result<void> write_text(const fs::path& path, std::string_view text) {
  return write_whole_file(path, std::as_bytes(std::span(text)));
}

Result<void> create_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return {};
  return fail(Status::io_error,
              fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
}

/// Whether an earlier publication wrote this folder.
bool is_site(const fs::path& folder) {
  return first_bytes(folder / kCatalogFile, kCatalogBeginning.size()) == kCatalogBeginning;
}

Result<void> check_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (!fs::exists(folder, error)) return {};
  if (!fs::is_directory(folder, error)) {
    return fail(Status::invalid_argument, fmt::format("{}: expected a folder for the site, found a "
                                                      "file: give another name with --to",
                                                      folder.string()));
  }
  if (force || fs::is_empty(folder, error) || is_site(folder)) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected no folder, an empty one, or a published site, found other "
                          "files: give another name with --to, or write into it with --force",
                          folder.string()));
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

/// Copies the store in the state in which it was opened.
Result<void> copy_store(const StoreFile& store, const fs::path& to,
                        const std::function<void(uint64_t bytes)>& copied) {
  constexpr uint64_t kPiece = uint64_t{1} << 20;
  auto file = OutputFile::create(to);
  if (!file) return tl::unexpected(file.error());
  std::vector<std::byte> piece;
  const uint64_t size = store.info().file_bytes;
  for (uint64_t offset = 0; offset < size; offset += piece.size()) {
    piece.resize(std::min(kPiece, size - offset));
    if (auto read = store.read(offset, piece); !read) return read;
    if (auto written = file->write(offset, piece); !written) return written;
    copied(piece.size());
  }
  if (auto unchanged = store.check_unchanged(); !unchanged) return unchanged;
  return file->publish();
}

/// The file name of a picture. Different pictures of a store have different names.
std::string picture_file(const std::string& store, std::span<const std::byte> picture) {
  const std::string etag =
      server::etag_for({reinterpret_cast<const char*>(picture.data()), picture.size()});
  const std::string_view hash = std::string_view(etag).substr(1, etag.size() - 2);
  return fmt::format("{}-{}.png", store.substr(0, store.rfind('.')), hash);
}

/// Copies the pictures that `listed` names. Removes the name of a picture that was removed or
/// replaced meanwhile.
Result<void> copy_thumbnails(const Site& site, std::span<server::PublishedVolume> listed,
                             const fs::path& to) {
  for (size_t i = 0; i < listed.size(); ++i) {
    if (listed[i].thumbnail.empty()) continue;
    const auto picture = server::read_thumbnail(site.volumes[i].path, listed[i].content);
    if (!picture || picture_file(listed[i].file, *picture) != listed[i].thumbnail) {
      listed[i].thumbnail.clear();
    } else if (auto written = write_whole_file(to / listed[i].thumbnail, *picture); !written) {
      return written;
    }
  }
  return {};
}

/// Whether a path is the site's folder, or below it.
bool is_within(const fs::path& path, const fs::path& site) {
  std::error_code ignored;
  const auto real = [&](const fs::path& given) {
    return fs::weakly_canonical(fs::absolute(given, ignored), ignored);
  };
  const fs::path relative = real(path).lexically_relative(real(site));
  return !relative.empty() && *relative.begin() != "..";
}

bool has_content(const fs::path& path, const std::string& content) {
  const auto store = StoreFile::open(path);
  return store && (*store)->content() == content;
}

/// Removes stores and assets that the site does not use. `kept`: relative paths.
Result<std::vector<fs::path>> prune(const fs::path& site, const std::set<fs::path>& kept,
                                    std::span<const fs::path> inputs) {
  std::vector<fs::path> unused;
  for (const char* name : {"assets", "stores"}) {
    std::error_code error;
    for (fs::directory_iterator entry(site / name, error);
         !error && entry != fs::directory_iterator(); entry.increment(error)) {
      const fs::path relative = entry->path().lexically_relative(site);
      if (entry->is_regular_file() && !kept.contains(relative) &&
          check_not_input(entry->path(), inputs)) {
        unused.push_back(entry->path());
      }
    }
  }
  for (const fs::path& path : unused) {
    std::error_code error;
    fs::remove(path, error);
    if (error) {
      return fail(Status::io_error,
                  fmt::format("{}: cannot be removed: {}", path.string(), error.message()));
    }
  }
  return unused;
}

}  // namespace

Result<Site> publish_site(const SiteOptions& options) {
  if (auto checked = check_folder(options.to, options.force); !checked) {
    return tl::unexpected(checked.error());
  }
  const auto page = page_files(options.page);
  if (!page) return tl::unexpected(page.error());
  const auto index = site_index(page->back().source);
  if (!index) return tl::unexpected(index.error());

  std::string folder_error;
  server::Catalog catalog(options.stores, [&](std::string_view line) {
    if (line.starts_with("folder ")) folder_error = line;
  });
  catalog.scan();
  if (!folder_error.empty()) return fail(Status::io_error, folder_error);
  const auto entries = catalog.snapshot();
  Site site;
  std::vector<server::PublishedVolume> listed;
  std::vector<fs::path> inputs;
  std::set<fs::path> kept;
  for (const PageFile& file : *page) {
    inputs.push_back(file.source);
    kept.insert(file.relative);
  }
  uint64_t all_bytes = 0;
  // The site may be inside a folder that is published. Its own stores are published only if they
  // are named.
  const bool are_named = std::ranges::any_of(
      options.stores, [&](const fs::path& source) { return is_within(source, options.to); });
  for (const auto& [name, entry] : *entries) {
    if (!are_named && is_within(entry->folder, options.to)) continue;
    const auto store = StoreFile::open(entry->path);
    if (!store) return tl::unexpected(store.error());
    const std::string& content = (*store)->content();
    const std::string file = fmt::format("stores/{}-{}.isosplat", name, content);
    const bool is_new = !has_content(options.to / file, content);
    site.volumes.push_back({name, entry->path, file, is_new});
    listed.push_back({name, content, file, (*store)->info()});
    if (const auto picture = server::read_thumbnail(entry->path, content)) {
      listed.back().thumbnail = picture_file(file, *picture);
      kept.insert(listed.back().thumbnail);
    }
    inputs.push_back(entry->path);
    kept.insert(file);
    if (is_new) all_bytes += (*store)->info().file_bytes;
  }
  if (listed.empty()) {
    return fail(Status::invalid_argument,
                "expected at least one store, found none: isosplat build makes stores");
  }

  // All checks come before the first write.
  std::vector<fs::path> outputs{kCatalogFile};
  for (const PageFile& file : *page) outputs.push_back(file.relative);
  for (const SiteVolume& volume : site.volumes) {
    if (volume.is_new) outputs.emplace_back(volume.file);
  }
  for (const server::PublishedVolume& volume : listed) {
    if (!volume.thumbnail.empty()) outputs.emplace_back(volume.thumbnail);
  }
  for (const fs::path& output : outputs) {
    if (auto checked = check_not_input(options.to / output, inputs); !checked) {
      return tl::unexpected(checked.error());
    }
  }

  if (auto made = create_folders(options.to / "stores"); !made) return tl::unexpected(made.error());
  if (auto copied = copy_thumbnails(site, listed, options.to); !copied) {
    return tl::unexpected(copied.error());
  }
  uint64_t done = 0;
  for (size_t i = 0; i < site.volumes.size(); ++i) {
    const SiteVolume& volume = site.volumes[i];
    if (!volume.is_new) continue;
    // Opens the store again, since there may be more stores than a program may open at a time.
    const auto store = StoreFile::open(volume.path);
    if (!store) return tl::unexpected(store.error());
    if ((*store)->content() != listed[i].content) {
      return fail(Status::io_error, fmt::format("{}: was replaced while the site was written: "
                                                "publish it again",
                                                volume.path.string()));
    }
    auto copied = copy_store(**store, options.to / volume.file, [&](uint64_t bytes) {
      done += bytes;
      if (options.progress) options.progress(done, all_bytes);
    });
    if (!copied) return tl::unexpected(copied.error());
  }
  for (const PageFile& file : *page) {
    const bool is_index = file.relative == kIndexFile;
    // The compressed forms of index.html lack the elements that name the catalog.
    if (!is_index && file.relative.string().starts_with(std::string(kIndexFile) + ".")) continue;
    const fs::path to = options.to / file.relative;
    if (auto made = create_folders(to.parent_path()); !made) return tl::unexpected(made.error());
    if (is_index) {
      auto written = write_text(options.to / kCatalogFile, server::published_catalog_json(listed));
      if (!written) return tl::unexpected(written.error());
    }
    const auto text = is_index ? index : read_text(file.source);
    if (!text) return tl::unexpected(text.error());
    if (auto written = write_text(to, *text); !written) return tl::unexpected(written.error());
  }
  if (options.prune) {
    auto pruned = prune(options.to, kept, inputs);
    if (!pruned) return tl::unexpected(pruned.error());
    site.pruned = std::move(*pruned);
  }
  return site;
}

}  // namespace isosplat::cli
