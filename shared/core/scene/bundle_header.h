#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/store/store_reader.h"

// Bundles: a scene and its stores in one file (BUNDLE.md).
namespace isosplat {

/// The number of bytes that determine the size of a bundle's header.
inline constexpr size_t kBundlePrefixBytes = 64;
inline constexpr uint64_t kMaxBundleHeaderBytes = uint64_t{64} << 20;
inline constexpr size_t kMaxBundleStores = 65536;
/// The name of the scene's file in the folder into which a bundle is unpacked.
inline constexpr const char* kSceneName = "scene.json";

/// A range of a store that is contiguous in its bundle.
struct BundlePiece {
  uint64_t store_offset = 0;
  uint64_t bundle_offset = 0;
  uint64_t bytes = 0;
};

/// A store in a bundle. A viewer reads its header and its bootstrap range first: they lie in the
/// coarse part of the bundle. The rest lies in the fine part.
struct BundleStore {
  std::string path;  ///< as in the scene
  uint64_t file_bytes = 0;
  uint32_t header_bytes = 0;
  uint64_t bootstrap_offset = 0, bootstrap_bytes = 0;  ///< StoreReader::bootstrap_range
  std::array<uint8_t, 16> content_id{};
  uint64_t coarse_offset = 0, fine_offset = 0;  ///< in the bundle

  uint64_t coarse_bytes() const { return header_bytes + bootstrap_bytes; }
  /// The whole store, in ascending order; pieces of no bytes are left out.
  std::vector<BundlePiece> pieces() const;
};

struct BundleHeader {
  std::string scene;  ///< its text, byte for byte
  std::vector<BundleStore> stores;
  uint64_t header_bytes = 0;
  uint64_t coarse_bytes = 0;  ///< of all stores; they follow the header
  uint64_t file_bytes = 0;
};

/// A header with these stores, one after the other; their offsets are computed. `path`,
/// `file_bytes`, `header_bytes`, the bootstrap range and `content_id` of each must be set. Errors:
/// invalid_argument (too many stores, or more than 2^48 bytes).
Result<BundleHeader> plan_bundle(std::string scene, std::vector<BundleStore> stores);

/// The bytes of the header.
std::vector<std::byte> encode_bundle_header(const BundleHeader& header);

/// The size of the header that begins with these kBundlePrefixBytes bytes. Errors: not_a_store (no
/// bundle), unsupported_version, truncated, malformed_header.
Result<uint64_t> bundle_header_bytes(std::span<const std::byte> prefix);

/// Reads a header. Bytes are untrusted. Errors: those of bundle_header_bytes, and
/// checksum_mismatch. It does not check the scene: parse_scene() does.
Result<BundleHeader> parse_bundle_header(std::span<const std::byte> header);

/// Whether bytes begin as a bundle does.
bool is_bundle(std::span<const std::byte> first_bytes);

}  // namespace isosplat
