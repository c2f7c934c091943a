#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "server/http/message.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// Size of the header before each chunk in a response of frames, and the alignment of frames.
inline constexpr size_t kFrameHeaderBytes = 48;
inline constexpr size_t kFrameAlignment = 16;

/// Size of a frame: header, chunk and padding.
constexpr uint64_t frame_bytes(uint64_t chunk_bytes) {
  return kFrameHeaderBytes +
         (chunk_bytes + kFrameAlignment - 1) / kFrameAlignment * kFrameAlignment;
}

/// Chunks as frames, in the given order (HTTP.md shows the layout). Needs memory for one piece:
/// kPieceBytes, or one frame if that is larger. If a chunk cannot be read, or its checksum differs,
/// the stream ends with a frame that has the status and no chunk, unless it is the first frame. The
/// response is then shorter than its Content-Length, so no cache stores it.
class FrameStream final : public BodyStream {
 public:
  FrameStream(std::shared_ptr<const StoreFile> store, std::vector<ChunkRef> chunks);
  uint64_t size() const override { return size_; }
  uint64_t memory() const override;
  Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) override;

 private:
  std::shared_ptr<const StoreFile> store_;
  std::vector<ChunkRef> chunks_;
  size_t position_ = 0;
  uint64_t size_ = 0;
  uint64_t largest_ = 0;  ///< bytes of the largest frame
};

/// A byte range of a file. Checksums are not verified here: the client verifies them.
class FileStream final : public BodyStream {
 public:
  /// Reads bytes at an offset of the file. Errors are reported to clients.
  using Read = std::function<Result<void>(uint64_t offset, std::span<std::byte> out, NoWait*)>;

  FileStream(Read read, uint64_t offset, uint64_t bytes);
  /// A range of a store's file.
  FileStream(std::shared_ptr<const StoreFile> store, uint64_t offset, uint64_t bytes);
  uint64_t size() const override { return size_; }
  Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) override;

 private:
  Read read_;
  uint64_t offset_;
  uint64_t end_;
  uint64_t size_;
};

/// Size of the fields before the store's header in a bootstrap response.
inline constexpr size_t kBootstrapHeaderBytes = 32;

/// The bootstrap of a volume: content id, header, and the byte range StoreFile::bootstrap (HTTP.md
/// shows the layout). Checksums are not verified, as in FileStream.
class BootstrapStream final : public BodyStream {
 public:
  explicit BootstrapStream(std::shared_ptr<const StoreFile> store);
  uint64_t size() const override;
  Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) override;

 private:
  std::shared_ptr<const StoreFile> store_;
  FileStream rest_;  ///< the byte range after the header
  bool has_begun_ = false;
};

/// Target size of the pieces that streams produce.
inline constexpr size_t kPieceBytes = 64 * 1024;

}  // namespace isosplat::server
