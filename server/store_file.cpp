#include "server/store_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <mutex>
#include <system_error>
#include <utility>

#include "shared/store/checksum.h"

namespace isosplat {
namespace {

std::string system_message(int error) {
  return std::generic_category().message(error);
}

std::string hexadecimal(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

FileIdentity identity_of(const struct stat& status) {
  return {static_cast<uint64_t>(status.st_dev), static_cast<uint64_t>(status.st_ino),
          static_cast<uint64_t>(status.st_size),
          static_cast<int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec};
}

Result<void> read_exactly(int descriptor, uint64_t offset, std::span<std::byte> out) {
  while (!out.empty()) {
    const ssize_t got = ::pread(descriptor, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(Status::io_error, "cannot read: " + system_message(errno));
    if (got == 0) {
      return fail(Status::truncated, "expected " + std::to_string(out.size()) +
                                         " more bytes at offset " + std::to_string(offset) +
                                         ", found the end of the file: rebuild the store, or copy "
                                         "it again");
    }
    out = out.subspan(static_cast<size_t>(got));
    offset += static_cast<uint64_t>(got);
  }
  return {};
}

std::string describe(const ChunkRef& chunk) {
  const BlockKey& key = chunk.block;
  return "chunk " + std::to_string(key.level) + "/" + std::to_string(key.index.x) + "." +
         std::to_string(key.index.y) + "." + std::to_string(key.index.z) + "/" +
         std::to_string(chunk.slab);
}

Error checksum_error(const std::string& where, uint32_t expected, uint32_t found) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "(expected 0x%08x, found 0x%08x)", expected, found);
  return {Status::checksum_mismatch,
          where + ": checksum differs " + text.data() + ": rebuild the store, or copy it again"};
}

bool meets(CellInterval interval, float low, float high) {
  return static_cast<float>(interval.min) <= high && low < static_cast<float>(interval.max);
}

bool in_file_order(const ChunkRef& a, const ChunkRef& b) {
  return a.offset < b.offset;
}

}  // namespace

Result<FileIdentity> file_identity(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    return fail(Status::io_error, path.string() + ": " + system_message(errno));
  }
  return identity_of(status);
}

Result<std::shared_ptr<StoreFile>> StoreFile::open(const std::filesystem::path& path,
                                                   uint64_t directory_bytes) {
  const std::string name = path.string();
  const auto refused = [&](Status status, const std::string& why) {
    return fail(status, name + ": " + why);
  };
  // O_NONBLOCK: opening a pipe that someone named *.isosplat must not wait for its other end.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return refused(Status::io_error, "cannot open: " + system_message(errno));
  struct Closer {
    int descriptor;
    ~Closer() {
      if (descriptor >= 0) ::close(descriptor);
    }
  } closer{descriptor};

  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return refused(Status::io_error, "cannot read: " + system_message(errno));
  }
  if (!S_ISREG(status.st_mode)) {
    return refused(Status::not_a_store, "expected a file, found something else");
  }
  const FileIdentity identity = identity_of(status);
  std::vector<std::byte> head(std::min<uint64_t>(kMaxHeadBytes, identity.bytes));
  if (Result<void> read = read_exactly(descriptor, 0, head); !read) {
    return refused(read.error().status, read.error().message);
  }
  Result<StoreReader> reader = StoreReader::open(head);
  if (!reader) return refused(reader.error().status, reader.error().message);
  if (reader->info().file_bytes != identity.bytes) {
    return refused(
        identity.bytes < reader->info().file_bytes ? Status::truncated : Status::malformed_header,
        "expected " + std::to_string(reader->info().file_bytes) + " bytes, found " +
            std::to_string(identity.bytes) + ": rebuild the store, or copy it again");
  }
  head.resize(std::min<uint64_t>(head.size(), reader->levels()[0].chunks_offset));
  closer.descriptor = -1;
  return std::shared_ptr<StoreFile>(new StoreFile(path, descriptor, identity, std::move(head),
                                                  std::move(*reader), directory_bytes));
}

StoreFile::StoreFile(std::filesystem::path path, int descriptor, FileIdentity identity,
                     std::vector<std::byte> head, StoreReader reader, uint64_t directory_bytes)
    : path_(std::move(path)),
      descriptor_(descriptor),
      identity_(identity),
      head_(std::move(head)),
      info_(reader.info()),
      pages_(reader.pages().begin(), reader.pages().end()),
      content_(hexadecimal(info_.content_id)),
      directory_bytes_(directory_bytes),
      reader_(std::move(reader)) {}

StoreFile::~StoreFile() {
  ::close(descriptor_);
}

Error StoreFile::at(Error error) const {
  error.message = path_.filename().string() + ": " + error.message;
  return error;
}

Result<void> StoreFile::check_unchanged() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) {
    return tl::unexpected(at({Status::io_error, "cannot read: " + system_message(errno)}));
  }
  const FileIdentity now = identity_of(status);
  if (now.bytes == identity_.bytes && now.modified_ns == identity_.modified_ns) return {};
  return tl::unexpected(
      at({Status::io_error,
          "the file was written to since it was opened: ask again, and replace stores by renaming "
          "a new file over the old one"}));
}

Result<void> StoreFile::read(uint64_t offset, std::span<std::byte> out) const {
  Result<void> result = check_unchanged();
  if (!result) return result;
  result = read_exactly(descriptor_, offset, out);
  if (!result) return tl::unexpected(at(std::move(result.error())));
  return {};
}

Result<std::vector<std::byte>> StoreFile::load_page(uint32_t page) const {
  const PageRef& ref = pages_[page];
  if (ref.offset > info_.file_bytes || ref.bytes > info_.file_bytes - ref.offset) {
    return tl::unexpected(at({Status::malformed_header, "page " + std::to_string(page) +
                                                            " ends beyond the file: rebuild the "
                                                            "store"}));
  }
  std::vector<std::byte> bytes(ref.bytes);
  if (Result<void> read = this->read(ref.offset, bytes); !read) return tl::unexpected(read.error());
  return bytes;
}

Result<void> StoreFile::make_resident(std::span<const uint32_t> pages) const {
  for (const uint32_t page : pages) {
    if (reader_.is_resident(page)) continue;
    Result<std::vector<std::byte>> bytes = load_page(page);
    if (!bytes) return tl::unexpected(bytes.error());
    if (Result<void> added = reader_.add_page(page, *bytes); !added) {
      return tl::unexpected(at(std::move(added.error())));
    }
    resident_bytes_ += bytes->size();
  }
  return {};
}

template <class LookUp>
auto StoreFile::with_pages(std::span<const uint32_t> pages, LookUp look_up) const
    -> decltype(look_up(std::declval<const StoreReader&>())) {
  {
    const std::shared_lock lock(mutex_);
    if (std::ranges::all_of(pages, [&](uint32_t page) { return reader_.is_resident(page); })) {
      return look_up(reader_);
    }
  }
  const std::unique_lock lock(mutex_);
  if (resident_bytes_ > directory_bytes_) {
    Result<StoreReader> fresh = StoreReader::open(head_);
    if (!fresh) return tl::unexpected(at(std::move(fresh.error())));
    reader_ = std::move(*fresh);
    resident_bytes_ = 0;
  }
  if (Result<void> loaded = make_resident(pages); !loaded) return tl::unexpected(loaded.error());
  return look_up(reader_);
}

Result<std::vector<std::byte>> StoreFile::read_page(uint32_t page) const {
  if (page >= pages_.size()) {
    return tl::unexpected(
        at({Status::not_found, "expected a page below " + std::to_string(pages_.size()) +
                                   ", found " + std::to_string(page)}));
  }
  Result<std::vector<std::byte>> bytes = load_page(page);
  if (bytes && checksum32(*bytes) != pages_[page].checksum) {
    return tl::unexpected(at(
        checksum_error("page " + std::to_string(page), pages_[page].checksum, checksum32(*bytes))));
  }
  return bytes;
}

Result<BlockRef> StoreFile::block(BlockKey key) const {
  // page_of answers from the head, which never changes: any of two readers gives the same.
  const Result<uint32_t> page = [&] {
    const std::shared_lock lock(mutex_);
    return reader_.page_of(key);
  }();
  if (!page) return tl::unexpected(at(page.error()));
  return with_pages({&*page, 1}, [&](const StoreReader& reader) { return reader.block(key); });
}

Result<ChunkRef> StoreFile::chunk(BlockKey block, uint32_t slab) const {
  const Result<uint32_t> page = [&] {
    const std::shared_lock lock(mutex_);
    return reader_.page_of(block);
  }();
  if (!page) return tl::unexpected(at(page.error()));
  return with_pages({&*page, 1},
                    [&](const StoreReader& reader) { return reader.chunk(block, slab); });
}

Result<std::optional<ChunkRef>> StoreFile::chunk_for(BlockKey block, float isocode) const {
  const Result<uint32_t> page = [&] {
    const std::shared_lock lock(mutex_);
    return reader_.page_of(block);
  }();
  if (!page) return tl::unexpected(at(page.error()));
  return with_pages({&*page, 1},
                    [&](const StoreReader& reader) { return reader.chunk_for(block, isocode); });
}

Result<void> StoreFile::select(BlockKey key, float low, float high, const ChunkBudget& budget,
                               ChunkSelection& selection, const StoreReader& reader) const {
  const Result<BlockRef> block = reader.block(key);
  if (!block) return tl::unexpected(block.error());
  if (block->slab_count == 0 || !meets(block->interval, low, high)) return {};
  for (uint32_t slab = 0; slab < block->slab_count && !selection.over_budget; ++slab) {
    const Result<ChunkRef> chunk = reader.chunk(key, slab);
    if (!chunk) return tl::unexpected(chunk.error());
    if (static_cast<float>(chunk->slab_begin) > high) break;
    if (static_cast<float>(chunk->slab_end) <= low || chunk->bytes == 0) continue;
    selection.bytes += chunk->bytes;
    ++selection.count;
    selection.over_budget = selection.bytes > budget.bytes || selection.count > budget.chunks;
    selection.chunks.push_back(*chunk);
  }
  return {};
}

Result<ChunkSelection> StoreFile::chunks_for(uint32_t level, float low, float high,
                                             const ChunkBudget& budget) const {
  if (level >= info_.levels) {
    return tl::unexpected(
        at({Status::not_found, "expected a level below " + std::to_string(info_.levels) +
                                   ", found " + std::to_string(level)}));
  }
  ChunkSelection selection;
  for (uint32_t page = 0; page < pages_.size() && !selection.over_budget; ++page) {
    const PageRef& ref = pages_[page];
    if (ref.level != level || !meets(ref.interval, low, high)) continue;
    const auto select_page = [&](const StoreReader& reader) -> Result<void> {
      for (int32_t z = ref.first_block.z; z < ref.end_block.z; ++z) {
        for (int32_t y = ref.first_block.y; y < ref.end_block.y; ++y) {
          for (int32_t x = ref.first_block.x; x < ref.end_block.x; ++x) {
            if (selection.over_budget) return {};
            const BlockKey key{level, {x, y, z}};
            Result<void> done = select(key, low, high, budget, selection, reader);
            if (!done) return tl::unexpected(at(std::move(done.error())));
          }
        }
      }
      return {};
    };
    if (Result<void> done = with_pages({&page, 1}, select_page); !done) {
      return tl::unexpected(done.error());
    }
  }
  if (selection.over_budget) {
    selection.chunks.clear();
  } else {
    std::sort(selection.chunks.begin(), selection.chunks.end(), in_file_order);
  }
  return selection;
}

Result<ChunkSelection> StoreFile::chunks_for(std::span<const BlockKey> blocks, float low,
                                             float high, const ChunkBudget& budget) const {
  ChunkSelection selection;
  for (const BlockKey& key : blocks) {
    const Result<uint32_t> page = [&] {
      const std::shared_lock lock(mutex_);
      return reader_.page_of(key);
    }();
    if (!page) return tl::unexpected(at(page.error()));
    if (!meets(pages_[*page].interval, low, high)) continue;
    Result<void> done = with_pages({&*page, 1}, [&](const StoreReader& reader) {
      return select(key, low, high, budget, selection, reader);
    });
    if (!done) return tl::unexpected(at(std::move(done.error())));
    if (selection.over_budget) break;
  }
  if (selection.over_budget) selection.chunks.clear();
  return selection;
}

Result<void> StoreFile::read_chunk(const ChunkRef& chunk, std::vector<std::byte>& out) const {
  if (chunk.offset > info_.file_bytes || chunk.bytes > info_.file_bytes - chunk.offset) {
    return tl::unexpected(at({Status::truncated, describe(chunk) + " ends beyond the file: rebuild "
                                                                   "the store"}));
  }
  const size_t before = out.size();
  out.resize(before + chunk.bytes);
  const std::span<std::byte> bytes = std::span(out).subspan(before);
  Result<void> result = read(chunk.offset, bytes);
  if (result) {
    const uint32_t found = checksum32(bytes);
    if (found == chunk.checksum) return {};
    result = tl::unexpected(at(checksum_error(describe(chunk), chunk.checksum, found)));
  }
  out.resize(before);
  return result;
}

}  // namespace isosplat
