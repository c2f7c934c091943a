#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "shared/core/store/store_writer.h"
#include "shared/system/posix_file/posix_file.h"

// Files of encoded blocks: parts of a build, and the finished blocks of a build that can be
// resumed. They are read by the version of the program that wrote them. Numbers are little-endian.
//
//   header   magic 8 │ key 8 │ part 4 │ parts 4 │ version 8 │ checksum of these 8
//   frames   kind 4 │ level 4 │ z 4 │ number 4 │ bytes 8 │ checksum of them 8 │ of these 8 │ bytes
namespace isosplat {

/// One of n parts of a build, 1 ≤ number ≤ count.
struct Part {
  uint32_t number = 1, count = 1;
  friend bool operator==(const Part&, const Part&) = default;
};

/// The most parts of a build.
inline constexpr uint32_t kMaxParts = 1'000'000;

/// What a frame of a block file holds.
enum class FrameKind : uint32_t {
  block = 1,       ///< a message of write_encoded: block `number` of the layer z of a level
  statistics = 2,  ///< VolumeStatistics::bytes(), of the layer z of level 0, or of a part
  end = 3,         ///< of a part: all of its blocks are in the file
};

struct BlockFileHeader {
  uint64_t key = 0;  ///< block_file_key()
  Part part;
};

struct Frame {
  FrameKind kind{};
  uint32_t level = 0, z = 0, number = 0;
  uint64_t bytes = 0, checksum = 0;  ///< of the content
  uint64_t offset = 0;               ///< of the content in the file
};

/// Writes a block file from its beginning, or from the end of its last frame.
class BlockFileWriter {
 public:
  /// The sink must outlive the writer. offset: where the next frame begins.
  explicit BlockFileWriter(ByteSink& sink, uint64_t offset = 0) : sink_(sink), offset_(offset) {}

  /// Errors: io_error.
  Result<void> write_header(const BlockFileHeader& header);
  Result<void> write(FrameKind kind, uint32_t level, uint32_t z, uint32_t number,
                     std::span<const std::byte> content);

 private:
  ByteSink& sink_;
  uint64_t offset_;
};

/// An open block file.
class BlockFile {
 public:
  /// Reads the header and the heads of all frames. Errors: io_error; invalid_argument (the file is
  /// no block file, or one of another version).
  static Result<BlockFile> open(const std::filesystem::path& path);
  /// Whether a file begins as a block file of any version does.
  static bool is_block_file(const PosixFile& file);

  const BlockFileHeader& header() const { return header_; }
  /// All frames that are whole, in the order in which they were written.
  const std::vector<Frame>& frames() const { return frames_; }
  /// The end of the last whole frame.
  uint64_t end() const { return end_; }
  /// Whether bytes follow that are no whole frame.
  bool is_cut_off() const { return is_cut_off_; }
  const std::string& file_name() const { return file_.name(); }

  /// Reads the content of a frame. False if its checksum differs. Errors: io_error. Threads may
  /// call it at the same time.
  Result<bool> read(const Frame& frame, std::vector<std::byte>& content) const;

 private:
  PosixFile file_;
  BlockFileHeader header_;
  std::vector<Frame> frames_;
  uint64_t end_ = 0;
  bool is_cut_off_ = false;
};

}  // namespace isosplat
