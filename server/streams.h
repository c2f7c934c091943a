#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/message.h"
#include "shared/store_file/store_file.h"

namespace isosplat {

/// Bytes of the frame before each chunk in an answer of many, and what frames are padded to.
inline constexpr size_t kFrameHeaderBytes = 48;
inline constexpr size_t kFrameAlignment = 16;

/// The frame's bytes: header, chunk, padding.
constexpr uint64_t frame_bytes(uint64_t chunk_bytes) {
  return kFrameHeaderBytes +
         (chunk_bytes + kFrameAlignment - 1) / kFrameAlignment * kFrameAlignment;
}

/// Chunks as frames, in the order given (HTTP.md draws the layout). Holds a piece at a time:
/// kPieceBytes, or one frame where that is larger. A chunk that cannot be read, or whose checksum
/// differs, ends the stream with a frame that carries the status and no chunk, so that the answer
/// falls short of its announced length and no cache keeps it.
class FrameStream final : public BodyStream {
 public:
  FrameStream(std::shared_ptr<const StoreFile> store, std::vector<ChunkRef> chunks);
  uint64_t size() const override { return size_; }
  Step next(std::vector<std::byte>& out, Error& error) override;

 private:
  std::shared_ptr<const StoreFile> store_;
  std::vector<ChunkRef> chunks_;
  size_t position_ = 0;
  uint64_t size_ = 0;
};

/// A run of the store file's bytes, unchecked: its reader checks each part of it.
class FileStream final : public BodyStream {
 public:
  FileStream(std::shared_ptr<const StoreFile> store, uint64_t offset, uint64_t bytes);
  uint64_t size() const override { return size_; }
  Step next(std::vector<std::byte>& out, Error& error) override;

 private:
  std::shared_ptr<const StoreFile> store_;
  uint64_t offset_;
  uint64_t end_;
  uint64_t size_;
};

/// Bytes before the header in an answer that opens a volume.
inline constexpr size_t kBootstrapHeaderBytes = 32;

/// What a viewer needs for its first picture: content id, header, and StoreFile::bootstrap (HTTP.md
/// draws the layout). As unchecked as FileStream.
class BootstrapStream final : public BodyStream {
 public:
  explicit BootstrapStream(std::shared_ptr<const StoreFile> store);
  uint64_t size() const override;
  Step next(std::vector<std::byte>& out, Error& error) override;

 private:
  std::shared_ptr<const StoreFile> store_;
  FileStream rest_;  ///< what follows the header
  bool begun_ = false;
};

/// What streams aim to make at a time: a connection's buffer.
inline constexpr size_t kPieceBytes = 64 * 1024;

}  // namespace isosplat
