#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace isosplat::server {

/// These bytes as a gzip file. `level`: of zlib, 1 (fast) to 9 (small). Empty if zlib cannot
/// allocate memory. The same bytes always give the same file.
std::string gzipped(std::string_view bytes, int level);

/// Compresses bodies of responses, such as the list of volumes, or the headers of a scene's stores.
/// Caches the most recent results, since many clients request the same ones. Thread-safe.
class Compressor {
 public:
  using Compressed = std::shared_ptr<const std::string>;

  /// The body as a gzip file. `hash`: identifies the body, for example its ETag. Null if the body
  /// must be sent uncompressed: only one long body is compressed at a time, so that compression
  /// occupies at most one core, no matter how many clients request which bodies.
  Compressed compress(std::string_view body, const std::string& hash);

  /// The cached result of compress(): null if compression does not make the body smaller. Empty if
  /// it is not cached.
  std::optional<Compressed> find(const std::string& hash) const;

  /// Shorter bodies are sent uncompressed: they fit in one or two packets.
  static constexpr size_t kMinBytes = 1400;
  /// Longer bodies take so long that a connection's thread should not compress them.
  static constexpr size_t kLongBytes = 64 * 1024;

 private:
  static constexpr size_t kKeptBytes = 4 << 20;

  struct Kept {
    std::string hash;
    Compressed file;
  };
  void keep(const std::string& hash, Compressed file);

  mutable std::mutex mutex_;
  std::list<Kept> kept_;    // guarded by mutex_; the latest first
  size_t kept_bytes_ = 0;   // guarded by mutex_
  std::mutex compressing_;  ///< held while a long body is compressed
};

}  // namespace isosplat::server
