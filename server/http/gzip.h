#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace isosplat::server {

/// These bytes as a gzip file. `level`: of zlib, 1 (fast) to 9 (small). Empty if zlib has no
/// memory. The same bytes give the same file.
std::string gzipped(std::string_view bytes, int level);

/// Compresses texts that are made for each request, such as the list of volumes, and keeps those
/// that it compressed last: many clients ask for the same one. Thread-safe.
class TextCompressor {
 public:
  using Compressed = std::shared_ptr<const std::string>;

  /// The text as a gzip file. `hash`: names the text, such as its ETag. Null if it must be sent as
  /// it is: one long text is compressed at a time, so that clients cannot keep more than one core
  /// busy with it, however many they are and whatever they ask for.
  Compressed compress(std::string_view text, const std::string& hash);

  /// Whether compress() would take so long that a connection's thread should not do it.
  bool is_slow(std::string_view text, const std::string& hash) const;

  /// Texts below are sent as they are: they fit in one packet or two.
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
