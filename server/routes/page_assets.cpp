#include "server/routes/page_assets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>
#include <utility>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "server/http/gzip.h"

namespace isosplat::server {
namespace {

namespace fs = std::filesystem;

struct MimeType {
  std::string_view extension;
  std::string_view name;
  bool compresses;
};

constexpr auto kMimeTypes = std::to_array<MimeType>({
    {".html", "text/html; charset=utf-8", true},
    {".js", "text/javascript; charset=utf-8", true},
    {".mjs", "text/javascript; charset=utf-8", true},
    {".css", "text/css; charset=utf-8", true},
    {".wasm", "application/wasm", true},
    {".json", "application/json", true},
    {".map", "application/json", true},
    {".webmanifest", "application/manifest+json", true},
    {".svg", "image/svg+xml", true},
    {".txt", "text/plain; charset=utf-8", true},
    {".png", "image/png", false},
    {".jpg", "image/jpeg", false},
    {".webp", "image/webp", false},
    {".avif", "image/avif", false},
    {".ico", "image/x-icon", true},
    {".woff2", "font/woff2", false},
    {".woff", "font/woff", false},
});
constexpr MimeType kUnknownType{"", "application/octet-stream", false};

const MimeType& mime_type(std::string_view path) {
  const auto found = std::ranges::find_if(
      kMimeTypes, [&](const MimeType& type) { return path.ends_with(type.extension); });
  return found == kMimeTypes.end() ? kUnknownType : *found;
}

/// Whether a path has Vite's form for immutable files: "/assets/NAME-HASH.EXTENSION" with a hash of
/// at least 8 letters, digits, "-" and "_".
bool has_hashed_name(std::string_view path) {
  constexpr size_t kHashLength = 8;
  if (!path.starts_with("/assets/")) return false;
  const std::string_view file = path.substr(path.rfind('/') + 1);
  const size_t dot = file.find('.');
  if (dot == std::string_view::npos || dot < kHashLength + 2) return false;
  const std::string_view hash = file.substr(dot - kHashLength, kHashLength);
  const auto is_hash_character = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return file[dot - kHashLength - 1] == '-' && std::ranges::all_of(hash, is_hash_character);
}

Result<std::string> read_file(const fs::path& path, uint64_t max_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const uint64_t size = fs::file_size(path, error);
  if (!file || error) return fail(Status::io_error, path.string() + ": cannot read");
  if (size > max_bytes) {
    return fail(Status::invalid_argument,
                fmt::format("{}: the page's files exceed the memory limit: serve a folder that "
                            "contains only the built page",
                            path.string()));
  }
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (file.gcount() != static_cast<std::streamsize>(size)) {
    return fail(Status::io_error, path.string() + ": changed while it was read");
  }
  return bytes;
}

/// All regular files below root, by their paths relative to root with a leading "/".
std::map<std::string, fs::path> files_below(const fs::path& root, const PageAssets::Log& log,
                                            std::error_code& error) {
  constexpr size_t kMaxFiles = 10'000;
  std::map<std::string, fs::path> files;
  const fs::path real_root = fs::canonical(root, error);
  if (error) return files;
  fs::recursive_directory_iterator entry(real_root, error);
  for (size_t seen = 0; !error && seen < kMaxFiles && entry != fs::recursive_directory_iterator();
       ++seen, entry.increment(error)) {
    std::error_code ignored;
    // Skips .git and .env, for example; but /.well-known is for clients (RFC 8615).
    const std::string name = entry->path().filename().string();
    if (name.starts_with('.') && !(name == ".well-known" && entry.depth() == 0)) {
      entry.disable_recursion_pending();
      continue;
    }
    if (!entry->is_regular_file(ignored)) continue;
    const fs::path real = fs::canonical(entry->path(), ignored);
    const auto [root_end, where] = std::ranges::mismatch(real_root, real);
    if (ignored || root_end != real_root.end()) {
      if (log)
        log(fmt::format("page: {}: a link out of the folder: not served", entry->path().string()));
      continue;
    }
    std::string path = "/";
    path += entry->path().lexically_relative(real_root).generic_string();
    files.emplace(std::move(path), entry->path());
  }
  return files;
}

}  // namespace

std::string_view mime_type_of(std::string_view path) {
  return mime_type(path).name;
}

Result<std::shared_ptr<PageAssets>> PageAssets::load(const fs::path& root, uint64_t max_bytes,
                                                     const Log& log) {
  std::error_code error;
  const std::map<std::string, fs::path> files = files_below(root, log, error);
  if (error) {
    return fail(Status::io_error,
                fmt::format("page folder {}: {}", root.string(), error.message()));
  }
  auto page = std::make_shared<PageAssets>();
  uint64_t left = max_bytes;
  const auto variant = [&](Encoding encoding, std::string bytes) {
    left -= std::min<uint64_t>(left, bytes.size());
    std::string etag = etag_for(bytes);
    return AssetVariant{encoding, std::move(bytes), std::move(etag)};
  };
  for (const auto& listed : files) {
    const std::string& path = listed.first;
    const fs::path& file = listed.second;
    const auto is_variant_of = [&](std::string_view extension) {
      return path.ends_with(extension) &&
             files.contains(path.substr(0, path.size() - extension.size()));
    };
    if (is_variant_of(".gz") || is_variant_of(".br")) continue;
    Result<std::string> bytes = read_file(file, left);
    if (!bytes) return tl::unexpected(bytes.error());
    const MimeType& type = mime_type(path);
    Asset asset{type.name, has_hashed_name(path), {}};
    asset.variants.push_back(variant(Encoding::identity, std::move(*bytes)));
    for (const auto& [extension, encoding] :
         {std::pair{".gz", Encoding::gzip}, std::pair{".br", Encoding::brotli}}) {
      const auto encoded = files.find(path + extension);
      if (encoded == files.end()) continue;
      Result<std::string> encoded_bytes = read_file(encoded->second, left);
      if (!encoded_bytes) return tl::unexpected(encoded_bytes.error());
      asset.variants.push_back(variant(encoding, std::move(*encoded_bytes)));
    }
    if (type.compresses && !files.contains(path + ".gz")) {
      const std::string& plain = asset.variants.front().bytes;
      std::string small = gzipped(plain, 9);
      if (!small.empty() && small.size() < plain.size()) {
        asset.variants.push_back(variant(Encoding::gzip, std::move(small)));
      }
    }
    std::ranges::stable_sort(asset.variants, {},
                             [](const AssetVariant& item) { return item.bytes.size(); });
    page->assets_.emplace(path, std::make_shared<const Asset>(std::move(asset)));
  }
  return page;
}

const Asset* PageAssets::find(std::string_view path) const {
  auto found = assets_.find(path);
  if (found == assets_.end() && path.ends_with('/')) {
    found = assets_.find(std::string(path) + "index.html");
  }
  if (found != assets_.end()) return found->second.get();
  const auto kept = kept_.find(path);
  return kept == kept_.end() ? nullptr : kept->second.asset.get();
}

std::vector<std::string> PageAssets::missing() const {
  constexpr std::string_view kFolder = "assets/";
  const auto ends_name = [](char c) {
    return c == '"' || c == '\'' || c == '?' || c == '#' || c == ')' || c == '>' || c == '<' ||
           c == ' ' || c == '\n';
  };
  std::vector<std::string> names;
  for (const auto& [path, asset] : assets_) {
    if (!path.ends_with(".html")) continue;
    const auto plain =
        std::ranges::find(asset->variants, Encoding::identity, &AssetVariant::encoding);
    const std::string_view html = plain->bytes;
    for (size_t at = html.find(kFolder); at != html.npos; at = html.find(kFolder, at + 1)) {
      const auto end = std::ranges::find_if(html.substr(at), ends_name);
      std::string name = "/";
      name += std::string_view(html.begin() + static_cast<std::ptrdiff_t>(at), end);
      if (has_hashed_name(name) && !assets_.contains(name)) names.push_back(std::move(name));
    }
  }
  return names;
}

void PageAssets::keep_hashed(const PageAssets& before, uint64_t max_bytes,
                             std::chrono::seconds kept_for) {
  const Clock::time_point now = Clock::now();
  std::vector<std::pair<std::string, Kept>> candidates;
  for (const auto& [path, asset] : before.assets_) {
    if (asset->immutable) candidates.push_back({path, {asset, now + kept_for}});
  }
  for (const auto& [path, kept] : before.kept_) {
    if (kept.until > now) candidates.push_back({path, kept});
  }
  std::ranges::stable_sort(candidates, std::ranges::greater{},
                           [](const auto& candidate) { return candidate.second.until; });
  for (auto& [path, kept] : candidates) {
    if (assets_.contains(path)) continue;
    uint64_t bytes = 0;
    for (const AssetVariant& variant : kept.asset->variants) bytes += variant.bytes.size();
    if (bytes > max_bytes) return;
    max_bytes -= bytes;
    kept_.emplace(std::move(path), std::move(kept));
  }
}

uint64_t PageAssets::signature(const fs::path& root) {
  std::error_code error;
  std::string text;
  for (const auto& [path, file] : files_below(root, {}, error)) {
    std::error_code ignored;
    text += fmt::format("{} {} {}\n", path, fs::file_size(file, ignored),
                        fs::last_write_time(file, ignored).time_since_epoch().count());
  }
  return XXH3_64bits(text.data(), text.size());
}

}  // namespace isosplat::server
