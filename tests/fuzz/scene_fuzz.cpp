// Hostile scenes, and headers of bundles with correct checksums. The first byte chooses between
// them.
#include <cstdlib>
#include <cstring>

#include "shared/core/scene/bundle_header.h"
#include "shared/core/scene/scene.h"
#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

void read_bundle(std::vector<std::byte> bytes) {
  const size_t size = bytes.size() / 8 * 8;
  bytes.resize(size);
  if (size < kBundlePrefixBytes + 8) return;
  constexpr uint8_t kMagic[] = {0x89, 'I', 'S', 'O', 'B', 0x0d, 0x0a, 0x1a, 1, 0, 0, 0};
  std::memcpy(bytes.data(), kMagic, sizeof kMagic);
  write_le(bytes.data() + 12, 4, size);
  write_le(bytes.data() + size - 8, 8, checksum64(std::span(bytes).first(size - 8)));
  const auto header = parse_bundle_header(bytes);
  if (!header) return;
  for (const BundleStore& store : header->stores) {
    if (!is_path_below(store.path)) std::abort();
    uint64_t at = 0;
    for (const BundlePiece& piece : store.pieces()) {
      if (piece.store_offset != at) std::abort();
      if (piece.bundle_offset + piece.bytes > header->file_bytes) std::abort();
      at += piece.bytes;
    }
    if (at != store.file_bytes) std::abort();
  }
}

void read_scene(std::string_view text) {
  const auto scene = parse_scene(text);
  if (!scene) return;
  for (const SceneLayer& layer : scene->layers) {
    if (layer.stores.empty()) std::abort();
    const VolumeGrid grid{{4, 5, 6}};
    if (!layer.transform) continue;
    const auto moved = transformed(grid, *layer.transform);
    if (moved && !is_basis(moved->direction)) std::abort();
  }
  if (store_paths(*scene).empty()) std::abort();
}

}  // namespace
}  // namespace isosplat

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const auto* bytes = reinterpret_cast<const std::byte*>(data + 1);
  if (data[0] == 'b') {
    isosplat::read_bundle({bytes, bytes + size - 1});
  } else {
    isosplat::read_scene({reinterpret_cast<const char*>(data + 1), size - 1});
  }
  return 0;
}
