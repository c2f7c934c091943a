#include "server/http/streams.h"

#include <algorithm>
#include <array>
#include <utility>

namespace isosplat::server {
namespace {

void append_u32(std::vector<std::byte>& out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(value >> shift));
}

/// byte  0        4        8       12       16       20       24       28
///      +--------+--------+--------+--------+--------+--------+--------+--------+
///      | bytes  | status | level  |   x    |   y    |   z    |  band  | cells  |
///      +--------+--------+--------+--------+--------+--------+--------+--------+
///   32 | begin  |  end   |checksum|   0    | 48: the chunk's bytes, padded with 0 to 16
///      +--------+--------+--------+--------+
void append_frame_header(std::vector<std::byte>& out, const ChunkRef& chunk, Status status) {
  const bool has_chunk = status == Status::ok;
  const auto& index = chunk.block.index;
  for (const uint32_t value :
       {has_chunk ? chunk.bytes : 0, static_cast<uint32_t>(status), chunk.block.level,
        static_cast<uint32_t>(index.x), static_cast<uint32_t>(index.y),
        static_cast<uint32_t>(index.z), chunk.band, chunk.cells,
        static_cast<uint32_t>(chunk.band_begin), chunk.band_end, chunk.checksum, uint32_t{0}}) {
    append_u32(out, value);
  }
}

}  // namespace

FrameStream::FrameStream(std::shared_ptr<const StoreFile> store, std::vector<ChunkRef> chunks)
    : store_(std::move(store)), chunks_(std::move(chunks)) {
  for (const ChunkRef& chunk : chunks_) {
    size_ += frame_bytes(chunk.bytes);
    largest_ = std::max(largest_, frame_bytes(chunk.bytes));
  }
}

uint64_t FrameStream::memory() const {
  return kPieceBytes + largest_ + chunks_.capacity() * sizeof(ChunkRef);
}

BodyStream::Step FrameStream::next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) {
  while (position_ < chunks_.size()) {
    const ChunkRef& chunk = chunks_[position_];
    const size_t begin = out.size();
    append_frame_header(out, chunk, Status::ok);
    if (Result<void> read = store_->read_chunk(chunk, out, no_wait); !read) {
      out.resize(begin);
      if (no_wait && no_wait->needs_disk) return Step::more;
      if (position_ > 0) append_frame_header(out, chunk, read.error().status);
      error = std::move(read.error());
      return Step::broken;
    }
    out.resize(begin + frame_bytes(chunk.bytes), std::byte{0});
    ++position_;
    if (out.size() >= kPieceBytes) break;
  }
  return position_ == chunks_.size() ? Step::last : Step::more;
}

FileStream::FileStream(Read read, uint64_t offset, uint64_t bytes)
    : read_(std::move(read)), offset_(offset), end_(offset + bytes), size_(bytes) {}

FileStream::FileStream(std::shared_ptr<const StoreFile> store, uint64_t offset, uint64_t bytes)
    : FileStream(
          [store = std::move(store)](uint64_t at, std::span<std::byte> out, NoWait* no_wait) {
            return store->read(at, out, no_wait);
          },
          offset, bytes) {}

BodyStream::Step FileStream::next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) {
  const size_t begin = out.size();
  const size_t length = std::min<uint64_t>(kPieceBytes, end_ - offset_);
  out.resize(begin + length);
  if (Result<void> read = read_(offset_, std::span(out).subspan(begin), no_wait); !read) {
    out.resize(begin);
    if (no_wait && no_wait->needs_disk) return Step::more;
    error = std::move(read.error());
    return Step::broken;
  }
  offset_ += length;
  return offset_ == end_ ? Step::last : Step::more;
}

BootstrapStream::BootstrapStream(std::shared_ptr<const StoreFile> store)
    : store_(store), rest_(store, store->bootstrap().offset, store->bootstrap().bytes) {}

uint64_t BootstrapStream::size() const {
  return kBootstrapHeaderBytes + store_->header().size() + rest_.size();
}

BodyStream::Step BootstrapStream::next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) {
  if (has_begun_) return rest_.next(out, error, no_wait);
  const CoarseRange& bootstrap = store_->bootstrap();
  const std::span<const std::byte> header = store_->header();
  const std::array<uint8_t, 16>& id = store_->info().content_id;
  append_u32(out, static_cast<uint32_t>(header.size()));
  append_u32(out, static_cast<uint32_t>(bootstrap.bytes));
  append_u32(out, static_cast<uint32_t>(bootstrap.offset));
  append_u32(out, static_cast<uint32_t>(bootstrap.offset >> 32));
  for (const uint8_t byte : id) out.push_back(static_cast<std::byte>(byte));
  out.insert(out.end(), header.begin(), header.end());
  const size_t header_end = out.size();
  const Step step = rest_.next(out, error, no_wait);
  has_begun_ = step == Step::last || out.size() > header_end;
  if (!has_begun_) out.clear();
  return step;
}

}  // namespace isosplat::server
