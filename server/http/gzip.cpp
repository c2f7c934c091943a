#include "server/http/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

namespace isosplat::server {

std::string gzipped(std::string_view bytes, int level) {
  z_stream stream{};
  constexpr int kGzipFormat = 16, kMemoryLevel = 9;
  if (deflateInit2(&stream, level, Z_DEFLATED, MAX_WBITS + kGzipFormat, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    return {};
  }
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, deflateEnd);
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, Z_FINISH);
  out.resize(result == Z_STREAM_END ? stream.total_out : 0);
  return out;
}

namespace {

size_t bytes_of(const Compressor::Compressed& file) {
  return file ? file->size() : 0;
}

}  // namespace

Compressor::Compressed Compressor::compress(std::string_view body, const std::string& hash) {
  // Higher levels take several times as long for bodies that are mostly numbers.
  constexpr int kLevel = 1;
  if (body.size() < kMinBytes) return nullptr;
  if (const auto kept = find(hash)) return *kept;
  std::unique_lock<std::mutex> turn;
  if (body.size() > kLongBytes) {
    turn = std::unique_lock(compressing_, std::try_to_lock);
    if (!turn) return nullptr;
  }
  std::string file = gzipped(body, kLevel);
  if (file.empty()) return nullptr;
  Compressed compressed;
  if (file.size() < body.size()) {
    file.shrink_to_fit();
    compressed = std::make_shared<const std::string>(std::move(file));
  }
  keep(hash, compressed);
  return compressed;
}

std::optional<Compressor::Compressed> Compressor::find(const std::string& hash) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(kept_, hash, &Kept::hash);
  return found == kept_.end() ? std::nullopt : std::optional(found->file);
}

void Compressor::keep(const std::string& hash, Compressed file) {
  // Limits the time of a search through the list.
  constexpr size_t kMaxKept = 64;
  const std::lock_guard lock(mutex_);
  kept_bytes_ += bytes_of(file);
  kept_.push_front({hash, std::move(file)});
  while (kept_.size() > 1 && (kept_bytes_ > kKeptBytes || kept_.size() > kMaxKept)) {
    kept_bytes_ -= bytes_of(kept_.back().file);
    kept_.pop_back();
  }
}

}  // namespace isosplat::server
