#include "shared/import/codecs/file_head.h"

#include <span>
#include <utility>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/codecs/deflated_reader.h"

namespace isosplat::import {
namespace {

constexpr size_t kHeadBytes = 4096;
/// Bytes to use of damaged gzip data: enough for the headers of most formats.
constexpr size_t kDamagedHeadBytes = 540;

/// The first bytes of gzip data. Nothing if they cannot be decompressed.
std::optional<std::string> expanded_beginning(const std::filesystem::path& path) {
  const auto bytes = open_deflated(path);
  if (!bytes) return std::nullopt;
  const auto some = (*bytes)->count_after(0, kHeadBytes);
  std::string text(static_cast<size_t>(some.value_or(kDamagedHeadBytes)), '\0');
  if (!(*bytes)->read(0, std::as_writable_bytes(std::span(text)))) return std::nullopt;
  return text;
}

}  // namespace

Result<FileHead> read_head(const std::filesystem::path& path) {
  auto stored = read_beginning(path, kHeadBytes);
  if (!stored) return tl::unexpected(stored.error());
  FileHead head{path, std::move(*stored), Packing::none, std::nullopt};
  head.packing = packing_of(head.stored);
  if (head.is_gzip()) head.inside = expanded_beginning(path);
  return head;
}

}  // namespace isosplat::import
