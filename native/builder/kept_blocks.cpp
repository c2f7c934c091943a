#include "native/builder/kept_blocks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <tuple>

#include "native/builder/builder.h"
#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/store_build.h"
#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

tl::unexpected<Error> wrong(std::string message) {
  return fail(Status::invalid_argument, std::move(message));
}

/// The missing numbers of 1 to `count`, at most ten of them, as text.
std::string missing_numbers(const std::vector<const BlockFile*>& parts, size_t found) {
  std::vector<size_t> missing;
  for (size_t i = 0; i < parts.size() && missing.size() < 10; ++i) {
    if (!parts[i]) missing.push_back(i + 1);
  }
  const size_t all = parts.size() - found;
  return fmt::format("{}{}", fmt::join(missing, ", "),
                     all > missing.size() ? fmt::format(" and {} more", all - missing.size()) : "");
}

}  // namespace

uint64_t block_file_key(const StoreBuild& build, const BuildOptions& options) {
  const std::array keys{build.key(), checksum64(std::as_bytes(std::span(options.content_key)))};
  return checksum64(std::as_bytes(std::span(keys)));
}

Result<std::unique_ptr<KeptBlocks>> KeptBlocks::of_parts(
    std::span<const std::filesystem::path> parts) {
  std::unique_ptr<KeptBlocks> kept(new KeptBlocks);
  kept->is_join_ = true;
  if (parts.empty()) return wrong("expected the parts of a build, found none");
  for (const std::filesystem::path& path : parts) {
    auto file = BlockFile::open(path);
    if (!file) return tl::unexpected(file.error());
    kept->files_.push_back(std::move(*file));
  }
  const BlockFile& first = kept->files_.front();
  const uint32_t count = first.header().part.count;
  if (count < 1 || count > kMaxParts) return kept->damaged(first);
  std::vector<const BlockFile*> found(count);
  for (const BlockFile& file : kept->files_) {
    const Part part = file.header().part;
    if (part.count != count || file.header().key != first.header().key) {
      return wrong(fmt::format(
          "expected parts of one build, found {} of a build in {} parts, and {} of {} in {}: "
          "remove the parts of other builds",
          first.file_name(), count, file.file_name(),
          part.count != count ? "one" : "another volume or with other options", part.count));
    }
    if (part.number < 1 || part.number > count) return kept->damaged(file);
    const BlockFile*& same = found[part.number - 1];
    if (same) {
      return wrong(fmt::format("expected each part once, found part {} of {} twice: {} and {}",
                               part.number, count, same->file_name(), file.file_name()));
    }
    same = &file;
    if (file.is_cut_off() || file.frames().empty() || file.frames().back().kind != FrameKind::end) {
      return wrong(fmt::format(
          "{}: expected a complete part, found one that is cut off: build this part again",
          file.file_name()));
    }
  }
  if (kept->files_.size() < count) {
    return wrong(fmt::format("expected {} parts, found {}: build part {}", count,
                             kept->files_.size(), missing_numbers(found, kept->files_.size())));
  }
  return kept;
}

Result<std::unique_ptr<KeptBlocks>> KeptBlocks::of_interrupted(const std::filesystem::path& path) {
  std::unique_ptr<KeptBlocks> kept(new KeptBlocks);
  const int descriptor =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  if (descriptor < 0) return file_error(errno, path.string(), "opened");
  kept->output_ = PosixFile(descriptor, path.string());
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return file_error(errno, path.string(), "locked");
    return wrong(fmt::format("{}: another process builds this store: wait until it has ended",
                             path.string()));
  }
  const auto identity = kept->output_.identity();
  if (!identity) return tl::unexpected(identity.error());
  if (identity->bytes > 0 && !BlockFile::is_block_file(kept->output_)) {
    return wrong(
        fmt::format("{}: expected no file, or the blocks of an interrupted build, found "
                    "another file: move it away",
                    path.string()));
  }
  if (auto file = BlockFile::open(path)) kept->files_.push_back(std::move(*file));
  return kept;
}

Result<void> KeptBlocks::begin_file(uint64_t key) {
  uint64_t end = 0;
  if (!files_.empty() && files_[0].header().key == key) {
    end = files_[0].end();
  } else {
    files_.clear();
  }
  if (::ftruncate(output_.descriptor(), static_cast<off_t>(end)) != 0) {
    return file_error(errno, output_.name(), "written");
  }
  sink_ = std::make_unique<FileSink>(output_);
  writer_ = std::make_unique<BlockFileWriter>(*sink_, end);
  return end > 0 ? Result<void>() : writer_->write_header({key, {}});
}

Result<void> KeptBlocks::begin(uint64_t key, uint64_t blocks, VolumeStatistics& statistics) {
  if (is_join_) {
    if (files_[0].header().key != key) {
      return wrong(
          fmt::format("{}: expected a part of this volume, with these options, found a "
                      "part of another build: give join the arguments of the parts",
                      files_[0].file_name()));
    }
  } else if (auto begun = begin_file(key); !begun) {
    return begun;
  }
  for (const BlockFile& file : files_) {
    if (auto added = add_statistics(file, statistics); !added) return added;
  }
  std::sort(known_layers_.begin(), known_layers_.end());
  index_blocks();
  if (is_join_ && entries_.size() != blocks) {
    return wrong(fmt::format("expected the parts of all {} blocks, found {}: build all parts again",
                             blocks, entries_.size()));
  }
  return {};
}

Result<void> KeptBlocks::add_statistics(const BlockFile& file, VolumeStatistics& statistics) {
  std::vector<std::byte> content;
  for (const Frame& frame : file.frames()) {
    if (frame.kind != FrameKind::statistics) continue;
    // Blocks of an interrupted build are of use only with their layer's statistics.
    const bool is_known = !is_join_ && std::find(known_layers_.begin(), known_layers_.end(),
                                                 frame.z) != known_layers_.end();
    if (is_known) continue;
    const auto read = file.read(frame, content);
    if (!read) return tl::unexpected(read.error());
    if (!*read || !statistics.add(content)) {
      if (is_join_) return damaged(file);
      continue;
    }
    known_layers_.push_back(frame.z);
  }
  return {};
}

void KeptBlocks::index_blocks() {
  for (uint32_t i = 0; i < files_.size(); ++i) {
    for (const Frame& frame : files_[i].frames()) {
      if (frame.kind != FrameKind::block) continue;
      if (frame.level == 0 && !knows_layer(static_cast<int32_t>(frame.z))) continue;
      entries_.push_back({frame.level, frame.z, frame.number, i, frame});
    }
  }
  // The last frame of a block is the valid one: it was written since the others were damaged.
  const auto key = [](const Entry& e) { return std::tuple(e.level, e.z, e.number); };
  std::stable_sort(entries_.begin(), entries_.end(),
                   [&](const Entry& a, const Entry& b) { return key(a) < key(b); });
  const auto last = std::unique(entries_.rbegin(), entries_.rend(),
                                [&](const Entry& a, const Entry& b) { return key(a) == key(b); });
  entries_.erase(entries_.begin(), last.base());
}

bool KeptBlocks::knows_layer(int32_t z) const {
  return is_join_ ||
         std::binary_search(known_layers_.begin(), known_layers_.end(), static_cast<uint32_t>(z));
}

tl::unexpected<Error> KeptBlocks::damaged(const BlockFile& file) const {
  return wrong(
      fmt::format("{}: expected a part as it was written, found a damaged one (a checksum "
                  "differs): build this part again",
                  file.file_name()));
}

Result<bool> KeptBlocks::take(const Layer& layer, const CoarserLayer& coarser,
                              const BlockTask& task, std::vector<std::byte>& buffer,
                              EncodedBlock& block) {
  const auto wanted = std::tuple(layer.grid.level, static_cast<uint32_t>(task.index.z),
                                 static_cast<uint32_t>(task.number));
  const auto found = std::lower_bound(
      entries_.begin(), entries_.end(), wanted,
      [](const Entry& e, const auto& key) { return std::tuple(e.level, e.z, e.number) < key; });
  if (found == entries_.end() || std::tuple(found->level, found->z, found->number) != wanted) {
    if (is_join_ && layer.grid.level == 0) return damaged(files_[0]);
    return false;
  }
  const BlockFile& file = files_[found->file];
  const auto read = file.read(found->frame, buffer);
  if (!read) return tl::unexpected(read.error());
  const auto number = *read ? read_encoded(buffer, layer, coarser, block)
                            : fail(Status::invalid_argument, "damaged");
  if (!number || *number != task.number || !(block.storage_weight >= block.task_weight)) {
    if (is_join_) return damaged(file);
    return false;
  }
  if (!is_result_of(block, task)) {
    ++changed_;
    return false;
  }
  ++taken_;
  return true;
}

Result<void> KeptBlocks::keep(const Layer& layer, const CoarserLayer& coarser,
                              const BlockTask& task, const EncodedBlock& block,
                              std::vector<std::byte>& buffer) {
  if (!writer_) return {};
  write_encoded(layer, coarser, task.number, block, buffer);
  const std::lock_guard lock(mutex_);
  return writer_->write(FrameKind::block, layer.grid.level, static_cast<uint32_t>(task.index.z),
                        static_cast<uint32_t>(task.number), buffer);
}

Result<void> KeptBlocks::keep_statistics(int32_t z, const VolumeStatistics& statistics) {
  if (!writer_) return {};
  const std::lock_guard lock(mutex_);
  return writer_->write(FrameKind::statistics, 0, static_cast<uint32_t>(z), 0, statistics.bytes());
}

}  // namespace isosplat
