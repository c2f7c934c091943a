#include "shared/core/scene/bundle_header.h"

#include <algorithm>
#include <cstring>
#include <set>

#include "shared/core/scene/scene.h"
#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

constexpr std::array<uint8_t, 8> kMagic{0x89, 'I', 'S', 'O', 'B', 0x0d, 0x0a, 0x1a};
constexpr uint32_t kMajor = 1, kMinor = 0;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 48;
constexpr size_t kRecordBytes = 56;  // of a store, without its path
constexpr size_t kChecksumBytes = 8;

tl::unexpected<Error> malformed(const std::string& why) {
  return fail(Status::malformed_header, "bundle: " + why + ": make it again, or copy it again");
}

/// Rounds up to a multiple of 8. Cannot overflow: kMaxBundleHeaderBytes limits the sizes in memory.
size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

/// Computes the sizes and offsets that follow from the others. Returns false if they exceed the
/// limits.
bool place_stores(BundleHeader& header, uint64_t header_bytes) {
  header.header_bytes = header_bytes;
  uint64_t at = header_bytes;
  for (BundleStore& store : header.stores) {
    store.coarse_offset = at;
    at += store.coarse_bytes();
    if (at > kMaxFileBytes) return false;
  }
  header.coarse_bytes = at - header_bytes;
  for (BundleStore& store : header.stores) {
    store.fine_offset = at;
    at += store.file_bytes - store.coarse_bytes();
    if (at > kMaxFileBytes) return false;
  }
  header.file_bytes = at;
  return true;
}

}  // namespace

std::vector<BundlePiece> BundleStore::pieces() const {
  const uint64_t fine_chunks = bootstrap_offset - header_bytes;
  const uint64_t bootstrap_end = bootstrap_offset + bootstrap_bytes;
  std::vector<BundlePiece> pieces{
      {0, coarse_offset, header_bytes},
      {header_bytes, fine_offset, fine_chunks},
      {bootstrap_offset, coarse_offset + header_bytes, bootstrap_bytes},
      {bootstrap_end, fine_offset + fine_chunks, file_bytes - bootstrap_end}};
  std::erase_if(pieces, [](const BundlePiece& piece) { return piece.bytes == 0; });
  return pieces;
}

Result<BundleHeader> plan_bundle(std::string scene, std::vector<BundleStore> stores) {
  BundleHeader header{std::move(scene), std::move(stores)};
  uint64_t bytes = kBundlePrefixBytes + padded(header.scene.size());
  for (const BundleStore& store : header.stores) bytes += kRecordBytes + padded(store.path.size());
  bytes += kChecksumBytes;
  if (header.stores.size() > kMaxBundleStores || bytes > kMaxBundleHeaderBytes ||
      header.scene.size() > kMaxSceneBytes || !place_stores(header, bytes)) {
    return fail(Status::invalid_argument,
                "expected a scene of at most " + std::to_string(kMaxSceneBytes) +
                    " bytes with at most " + std::to_string(kMaxBundleStores) +
                    " stores of 2^48 bytes in all: make several bundles");
  }
  return header;
}

std::vector<std::byte> encode_bundle_header(const BundleHeader& header) {
  std::vector<std::byte> bytes;
  FieldWriter out(bytes);
  const auto pad = [&] { bytes.resize(padded(bytes.size())); };
  const auto add = [&](const void* data, size_t count) {
    if (count == 0) return;
    bytes.resize(bytes.size() + count);
    std::memcpy(bytes.data() + bytes.size() - count, data, count);
  };
  add(kMagic.data(), kMagic.size());
  out.field(2, kMajor);
  out.field(2, kMinor);
  out.field(4, header.header_bytes);
  out.field(8, header.file_bytes);
  out.field(8, header.coarse_bytes);
  out.field(4, header.scene.size());
  out.field(4, header.stores.size());
  bytes.resize(kBundlePrefixBytes);
  add(header.scene.data(), header.scene.size());
  pad();
  for (const BundleStore& store : header.stores) {
    out.field(8, store.file_bytes);
    out.field(8, store.bootstrap_offset);
    out.field(8, store.bootstrap_bytes);
    out.field(4, store.header_bytes);
    out.field(4, store.path.size());
    add(store.content_id.data(), store.content_id.size());
    out.field(8, 0);
    add(store.path.data(), store.path.size());
    pad();
  }
  out.field(8, checksum64(bytes));
  return bytes;
}

bool is_bundle(std::span<const std::byte> first_bytes) {
  return first_bytes.size() >= kMagic.size() &&
         std::equal(kMagic.begin(), kMagic.end(), first_bytes.begin(),
                    [](uint8_t a, std::byte b) { return std::byte{a} == b; });
}

Result<uint64_t> bundle_header_bytes(std::span<const std::byte> prefix) {
  if (!is_bundle(prefix)) {
    return fail(Status::not_a_store,
                "bundle: expected a file of isosplat bundle, found another kind of file");
  }
  if (prefix.size() < kBundlePrefixBytes) {
    return fail(Status::truncated, "bundle: expected at least 64 bytes: copy it again");
  }
  FieldReader in(prefix.data() + kMagic.size());
  const uint32_t major = in.u16(), minor = in.u16();
  if (major != kMajor) {
    return fail(Status::unsupported_version, "bundle: expected version " + std::to_string(kMajor) +
                                                 ", found " + std::to_string(major) + "." +
                                                 std::to_string(minor) + ": use a newer Isosplat");
  }
  const uint64_t bytes = in.u32();
  if (bytes % 8 != 0 || bytes < kBundlePrefixBytes + kChecksumBytes ||
      bytes > kMaxBundleHeaderBytes) {
    return malformed("expected a header of 72 to " + std::to_string(kMaxBundleHeaderBytes) +
                     " bytes, found " + std::to_string(bytes));
  }
  return bytes;
}

Result<BundleHeader> parse_bundle_header(std::span<const std::byte> bytes) {
  const auto header_bytes = bundle_header_bytes(bytes);
  if (!header_bytes) return tl::unexpected(header_bytes.error());
  if (bytes.size() < *header_bytes) {
    return fail(Status::truncated, "bundle: expected a header of " + std::to_string(*header_bytes) +
                                       " bytes, found " + std::to_string(bytes.size()) +
                                       ": copy it again");
  }
  bytes = bytes.first(static_cast<size_t>(*header_bytes));
  const size_t end = bytes.size() - kChecksumBytes;
  if (checksum64(bytes.first(end)) != read_le(bytes.data() + end, 8)) {
    return fail(Status::checksum_mismatch,
                "bundle: the checksum of the header differs: copy it again");
  }
  FieldReader in(bytes.data() + 16);
  BundleHeader header;
  const uint64_t file_bytes = in.u64(), coarse_bytes = in.u64();
  const uint32_t scene_bytes = in.u32(), stores = in.u32();
  if (scene_bytes > kMaxSceneBytes || kBundlePrefixBytes + padded(scene_bytes) > end) {
    return malformed("the scene ends beyond the header");
  }
  if (stores > kMaxBundleStores) return malformed("too many stores");
  size_t at = kBundlePrefixBytes;
  const auto text_at = [&](size_t offset, size_t count) {
    return std::string(reinterpret_cast<const char*>(bytes.data()) + offset, count);
  };
  header.scene = text_at(at, scene_bytes);
  at += padded(scene_bytes);
  std::set<std::string> paths;
  for (uint32_t i = 0; i < stores; ++i) {
    const std::string which = "store " + std::to_string(i);
    if (end - at < kRecordBytes) return malformed(which + " ends beyond the header");
    FieldReader record(bytes.data() + at);
    BundleStore store;
    store.file_bytes = record.u64();
    store.bootstrap_offset = record.u64();
    store.bootstrap_bytes = record.u64();
    store.header_bytes = record.u32();
    const uint32_t path_bytes = record.u32();
    for (uint8_t& byte : store.content_id) byte = record.u8();
    at += kRecordBytes;
    if (path_bytes > end - at || padded(path_bytes) > end - at) {
      return malformed(which + " ends beyond the header");
    }
    store.path = text_at(at, path_bytes);
    at += padded(path_bytes);
    if (!is_path_below(store.path) || store.path == kSceneName) {
      return malformed(which + ": expected a path below the scene's folder");
    }
    if (!paths.insert(store.path).second) return malformed(which + " has the path of another one");
    if (store.file_bytes > kMaxFileBytes || store.header_bytes > store.bootstrap_offset ||
        store.bootstrap_offset > store.file_bytes ||
        store.bootstrap_bytes > store.file_bytes - store.bootstrap_offset) {
      return malformed(which + ": its ranges contradict each other");
    }
    header.stores.push_back(std::move(store));
  }
  if (at != end || !place_stores(header, *header_bytes) || header.file_bytes != file_bytes ||
      header.coarse_bytes != coarse_bytes) {
    return malformed("the sizes in the header contradict each other");
  }
  return header;
}

}  // namespace isosplat
