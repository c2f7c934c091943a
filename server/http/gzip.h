#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace isosplat::server {

/// These bytes as a gzip file. `level`: of zlib, 1 (fast) to 9 (small). Empty if zlib cannot
/// allocate memory. The same bytes always give the same file.
std::string gzipped(std::string_view bytes, int level);

/// Compresses texts that are generated for each request, such as the list of volumes. Caches the
/// most recent results, since many clients request the same text. Thread-safe.
class TextCompressor {
 public:
  using Compressed = std::shared_ptr<const std::string>;

  /// The text as a gzip file. `hash`: identifies the text, for example its ETag. Null if the text
  /// must be sent uncompressed: only one long text is compressed at a time, so that compression
  /// occupies at most one core, no matter how many clients request which texts.
  Compressed compress(std::string_view text, const std::string& hash);

  /// Whether compress() would take so long that a connection's thread should not do it.
  bool is_slow(std::string_view text, const std::string& hash) const;

  /// Shorter texts are sent uncompressed: they fit in one or two packets.
  static constexpr size_t kMinBytes = 1400;

 private:
  static constexpr size_t kLongBytes = 64 * 1024;
  static constexpr size_t kKeptBytes = 4 << 20;

  struct Kept {
    std::string hash;
    Compressed file;
  };
  Compressed find(const std::string& hash) const;
  void keep(const std::string& hash, Compressed file);

  mutable std::mutex mutex_;
  std::list<Kept> kept_;    // guarded by mutex_; the latest first
  size_t kept_bytes_ = 0;   // guarded by mutex_
  std::mutex compressing_;  ///< held while a long text is compressed
};

}  // namespace isosplat::server
