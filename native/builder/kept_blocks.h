#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "native/builder/block_file.h"
#include "shared/core/builder/block_encoder.h"

namespace isosplat {

class StoreBuild;
struct BuildOptions;

/// Identifies volume and options of a build in block files: StoreBuild::key() and
/// BuildOptions::content_key.
uint64_t block_file_key(const StoreBuild& build, const BuildOptions& options);

/// Encoded blocks in files, which a build takes instead of encoding them: those of all parts of a
/// build, or those that an interrupted build has finished. A block is taken if encoding it now
/// would give the same bytes. Otherwise the build encodes it again, and reads its voxels only then.
class KeptBlocks {
 public:
  /// The blocks of all parts, from their files in any order. Errors: those of BlockFile::open;
  /// invalid_argument (a part is missing, incomplete or doubled, or belongs to another build).
  static Result<std::unique_ptr<KeptBlocks>> of_parts(std::span<const std::filesystem::path> parts);

  /// The blocks that an interrupted build has finished, and a file for those that this build
  /// finishes. Blocks of other volumes, options or versions of the program are discarded. Errors:
  /// io_error; invalid_argument (the file is another one, or another process is building with it).
  static Result<std::unique_ptr<KeptBlocks>> of_interrupted(const std::filesystem::path& path);

  /// Compares the key of the build (block_file_key), and adds the statistics of all known layers.
  /// blocks: how many level 0 has. Errors: io_error; invalid_argument (parts of another volume, or
  /// built with other options; a part is damaged).
  Result<void> begin(uint64_t key, uint64_t blocks, VolumeStatistics& statistics);

  /// Whether the statistics of a layer of level 0 are known.
  bool knows_layer(int32_t z) const;

  /// The encoded block of a task; writes its part of `coarser`. False if the block must be encoded.
  /// buffer: scratch memory of the thread. Threads may call it at the same time. Errors: io_error;
  /// invalid_argument (a part is damaged).
  Result<bool> take(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
                    std::vector<std::byte>& buffer, EncodedBlock& block);

  /// Keeps a block that was encoded, and the statistics of a layer of level 0 of which all blocks
  /// are kept. Nothing happens for parts. Threads may call it at the same time. Errors: io_error.
  Result<void> keep(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
                    const EncodedBlock& block, std::vector<std::byte>& buffer);
  Result<void> keep_statistics(int32_t z, const VolumeStatistics& statistics);

  /// How many blocks were taken, and how many were kept but had to be encoded again, since the size
  /// limit of the store has changed them.
  uint64_t taken() const { return taken_; }
  uint64_t changed() const { return changed_; }

 private:
  /// The frame of a block.
  struct Entry {
    uint32_t level, z, number;
    uint32_t file;
    Frame frame;
  };
  /// A file as the sink of a BlockFileWriter.
  class FileSink : public ByteSink {
   public:
    explicit FileSink(PosixFile& file) : file_(file) {}
    Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override {
      return file_.write(offset, bytes);
    }

   private:
    PosixFile& file_;
  };

  KeptBlocks() = default;
  Result<void> begin_file(uint64_t key);
  Result<void> add_statistics(const BlockFile& file, VolumeStatistics& statistics);
  void index_blocks();
  tl::unexpected<Error> damaged(const BlockFile& file) const;

  std::vector<BlockFile> files_;
  std::vector<Entry> entries_;  // ascending
  std::vector<uint32_t> known_layers_;
  bool is_join_ = false;
  PosixFile output_;  // of an interrupted build
  std::unique_ptr<FileSink> sink_;
  std::unique_ptr<BlockFileWriter> writer_;
  std::mutex mutex_;  // of writer_
  std::atomic<uint64_t> taken_{0}, changed_{0};
};

}  // namespace isosplat
