#include "shared/system/store_file/store_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <mutex>
#include <utility>

#include "shared/core/store/checksum.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

constexpr uint64_t kMaxRunBytes = uint64_t{4} << 20;
constexpr uint64_t kMaxPieceBytes = uint64_t{16} << 20;  // of a page that are read at once

std::string hexadecimal(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string describe(const ChunkRef& chunk) {
  return "chunk " + chunk_name(chunk.block, chunk.band);
}

Error checksum_error(const std::string& where, uint32_t expected, uint32_t found) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "(expected 0x%08x, found 0x%08x)", expected, found);
  return {Status::checksum_mismatch,
          where + ": checksum differs " + text.data() + ": rebuild the store, or copy it again"};
}

bool is_before_in_file(const ChunkRef& a, const ChunkRef& b) {
  return a.offset < b.offset;
}

/// Collects chunks until the budget is exceeded. From then on its functions return false.
class ChunkCollector {
 public:
  explicit ChunkCollector(const ChunkBudget& budget) : budget_(budget) {}

  /// Call it before a block of the page is read: counts the bytes of the page.
  bool begin_page(uint32_t page, const PageRef& ref) {
    if (page != last_page_) selection_.directory_bytes += ref.bytes;
    last_page_ = page;
    return require(selection_.directory_bytes <= budget_.directory_bytes);
  }

  bool add(std::span<const ChunkRef> chunks) {
    for (const ChunkRef& chunk : chunks) {
      selection_.bytes += chunk.bytes;
      ++selection_.count;
      if (!require(selection_.bytes <= budget_.bytes && selection_.count <= budget_.chunks)) break;
      selection_.chunks.push_back(chunk);
    }
    return !selection_.over_budget;
  }

  ChunkSelection finish() {
    if (selection_.over_budget) selection_.chunks.clear();
    return std::move(selection_);
  }

 private:
  bool require(bool is_within) {
    selection_.over_budget = selection_.over_budget || !is_within;
    return !selection_.over_budget;
  }

  const ChunkBudget& budget_;
  ChunkSelection selection_;
  uint32_t last_page_ = UINT32_MAX;
};

}  // namespace

Result<std::shared_ptr<StoreFile>> StoreFile::open(const std::filesystem::path& path,
                                                   uint64_t directory_bytes) {
  Result<PosixFile> file = PosixFile::open(path);
  if (!file) {
    std::error_code ignored;
    const bool is_other =
        std::filesystem::is_other(path, ignored) || std::filesystem::is_directory(path, ignored);
    return fail(is_other ? Status::not_a_store : Status::io_error, file.error().message);
  }
  const Result<FileIdentity> identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  // The server sends these messages to clients, so they must not name the folder.
  file->set_name(path.filename().string());
  auto shared = std::make_shared<const PosixFile>(std::move(*file));
  return open(FileParts(std::move(shared), identity->bytes), path, directory_bytes);
}

Result<std::shared_ptr<StoreFile>> StoreFile::open(FileParts parts,
                                                   const std::filesystem::path& path,
                                                   uint64_t directory_bytes, StoreKind kind) {
  const std::string name = path.string();
  const auto failed = [&](Status status, const std::string& why) {
    return fail(status, name + ": " + why);
  };
  const Result<FileIdentity> identity = parts.file().identity();
  if (!identity) return tl::unexpected(identity.error());
  std::vector<std::byte> header(std::min<uint64_t>(kMaxStoreHeaderBytes, parts.bytes()));
  if (Result<void> read = parts.read(0, header); !read) return tl::unexpected(read.error());
  Result<StoreReader> reader = StoreReader::open(header, kind);
  if (!reader) return failed(reader.error().status, reader.error().message);
  if (reader->info().file_bytes != parts.bytes()) {
    return failed(
        parts.bytes() < reader->info().file_bytes ? Status::truncated : Status::malformed_header,
        "expected " + std::to_string(reader->info().file_bytes) + " bytes, found " +
            std::to_string(parts.bytes()) + ": rebuild the store, or copy it again");
  }
  header.resize(std::min<uint64_t>(header.size(), reader->info().header_bytes));
  return std::shared_ptr<StoreFile>(new StoreFile(
      path, std::move(parts), *identity, std::move(header), std::move(*reader), directory_bytes));
}

StoreFile::StoreFile(std::filesystem::path path, FileParts file, FileIdentity identity,
                     std::vector<std::byte> header, StoreReader reader, uint64_t directory_bytes)
    : path_(std::move(path)),
      file_(std::move(file)),
      identity_(identity),
      header_(std::move(header)),
      info_(reader.info()),
      pages_(reader.pages().begin(), reader.pages().end()),
      bootstrap_(reader.bootstrap_range()),
      content_(hexadecimal(info_.content_id)),
      max_directory_bytes_(directory_bytes),
      reader_(std::move(reader)),
      last_use_(pages_.size()) {}

CoarseRange StoreFile::bootstrap_within(uint64_t max_bytes) const {
  return reader_.bootstrap_range(max_bytes);  // depends on the header alone
}

Error StoreFile::with_file_name(Error error) const {
  error.message = path_.filename().string() + ": " + error.message;
  return error;
}

Result<void> StoreFile::check_unchanged(NoWait* no_wait) const {
  const Result<FileIdentity> now = file_.file().identity(no_wait);
  if (!now) return tl::unexpected(now.error());
  if (now->has_same_content(identity_)) return {};
  return tl::unexpected(with_file_name(
      {Status::io_error,
       "the file was changed after it was opened: repeat the request, and replace a store by "
       "renaming a new file to its name"}));
}

Result<void> StoreFile::read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const {
  Result<void> result = check_unchanged(no_wait);
  if (!result) return result;
  return file_.read(offset, out, no_wait);
}

Result<std::vector<std::byte>> StoreFile::load_page(uint32_t page, NoWait* no_wait) const {
  const PageRef& ref = pages_[page];
  // The header only claims the size, so memory grows with the bytes that arrive.
  std::vector<std::byte> bytes;
  while (bytes.size() < ref.bytes) {
    const size_t begin = bytes.size();
    bytes.resize(begin + std::min<size_t>(kMaxPieceBytes, ref.bytes - begin));
    auto read = this->read(ref.offset + begin, std::span(bytes).subspan(begin), no_wait);
    if (!read) return tl::unexpected(read.error());
  }
  return bytes;
}

template <class Query>
auto StoreFile::with_page(uint32_t page, NoWait* no_wait, Query query) const
    -> decltype(query(std::declval<const StoreReader&>())) {
  last_use_[page] = ++uses_;
  {
    const std::shared_lock lock(mutex_);
    if (reader_.is_resident(page)) return query(reader_);
  }
  // Read and parse the page without the lock, so that other threads can use other pages.
  const Result<std::vector<std::byte>> bytes = load_page(page, no_wait);
  if (!bytes) return tl::unexpected(bytes.error());
  Result<ParsedPage> parsed = reader_.parse_page(page, *bytes);
  if (!parsed) return tl::unexpected(with_file_name(std::move(parsed.error())));
  {
    const std::unique_lock lock(mutex_);
    add_page(std::move(*parsed), page);
  }
  {
    const std::shared_lock lock(mutex_);
    if (reader_.is_resident(page)) return query(reader_);
  }
  // Another thread has dropped the page in the meantime. Add it again, and keep the lock.
  parsed = reader_.parse_page(page, *bytes);
  if (!parsed) return tl::unexpected(with_file_name(std::move(parsed.error())));
  const std::unique_lock lock(mutex_);
  add_page(std::move(*parsed), page);
  return query(reader_);
}

void StoreFile::add_page(ParsedPage&& parsed, uint32_t page) const {
  if (reader_.is_resident(page)) return;
  free_memory_for(pages_[page].bytes);
  reader_.add_page(std::move(parsed));
  resident_bytes_ += pages_[page].bytes;
}

void StoreFile::free_memory_for(uint64_t bytes) const {
  if (resident_bytes_ + bytes <= max_directory_bytes_) return;
  std::vector<std::pair<uint64_t, uint32_t>> by_last_use;  // last use, page
  for (uint32_t page = 0; page < pages_.size(); ++page) {
    if (reader_.is_resident(page)) by_last_use.emplace_back(last_use_[page].load(), page);
  }
  std::sort(by_last_use.begin(), by_last_use.end());
  // Free an eighth more than needed, so that not every new page has to free memory.
  const uint64_t max_resident = max_directory_bytes_ - max_directory_bytes_ / 8;
  for (const auto& [use, page] : by_last_use) {
    if (resident_bytes_ + bytes <= max_resident) break;
    reader_.remove_page(page);
    resident_bytes_ -= pages_[page].bytes;
  }
}

Result<std::vector<std::byte>> StoreFile::read_page(uint32_t page, NoWait* no_wait) const {
  if (page >= pages_.size()) {
    return tl::unexpected(with_file_name(
        {Status::not_found, "expected a page below " + std::to_string(pages_.size()) + ", found " +
                                std::to_string(page)}));
  }
  Result<std::vector<std::byte>> bytes = load_page(page, no_wait);
  if (bytes && checksum32(*bytes) != pages_[page].checksum) {
    return tl::unexpected(with_file_name(
        checksum_error("page " + std::to_string(page), pages_[page].checksum, checksum32(*bytes))));
  }
  return bytes;
}

Result<uint32_t> StoreFile::page_of(BlockKey block) const {
  Result<uint32_t> page = reader_.page_of(block);
  if (!page) return tl::unexpected(with_file_name(std::move(page.error())));
  return page;
}

Result<BlockRef> StoreFile::block(BlockKey key) const {
  const Result<uint32_t> page = page_of(key);
  if (!page) return tl::unexpected(page.error());
  return with_page(*page, nullptr, [&](const StoreReader& reader) { return reader.block(key); });
}

Result<ChunkRef> StoreFile::chunk(BlockKey block, uint32_t band, NoWait* no_wait) const {
  const Result<uint32_t> page = page_of(block);
  if (!page) return tl::unexpected(page.error());
  return with_page(*page, no_wait,
                   [&](const StoreReader& reader) { return reader.chunk(block, band); });
}

Result<std::optional<ChunkRef>> StoreFile::chunk_for(BlockKey block,
                                                     float quantized_isovalue) const {
  const Result<uint32_t> page = page_of(block);
  if (!page) return tl::unexpected(page.error());
  return with_page(*page, nullptr, [&](const StoreReader& reader) {
    return reader.chunk_for(block, quantized_isovalue);
  });
}

Result<ChunkSelection> StoreFile::chunks_for(uint32_t level, float low, float high,
                                             const ChunkBudget& budget, NoWait* no_wait,
                                             const BlockRange& where) const {
  if (level >= info_.levels) {
    return tl::unexpected(with_file_name(
        {Status::not_found, "expected a level below " + std::to_string(info_.levels) + ", found " +
                                std::to_string(level)}));
  }
  ChunkCollector collector(budget);
  for (uint32_t page = 0; page < pages_.size(); ++page) {
    const PageRef& ref = pages_[page];
    if (ref.level != level || !is_active_within(ref.interval, low, high)) continue;
    const Index3 first{std::max(ref.first_block.x, where.first.x),
                       std::max(ref.first_block.y, where.first.y),
                       std::max(ref.first_block.z, where.first.z)};
    const Index3 end{std::min(ref.end_block.x, where.end.x), std::min(ref.end_block.y, where.end.y),
                     std::min(ref.end_block.z, where.end.z)};
    if (first.x >= end.x || first.y >= end.y || first.z >= end.z) continue;
    if (!collector.begin_page(page, ref)) break;
    const auto select_page = [&](const StoreReader& reader) -> Result<void> {
      for (int32_t z = first.z; z < end.z; ++z) {
        for (int32_t y = first.y; y < end.y; ++y) {
          for (int32_t x = first.x; x < end.x; ++x) {
            const auto chunks = reader.chunks_for({level, {x, y, z}}, low, high);
            if (!chunks) return tl::unexpected(with_file_name(chunks.error()));
            if (!collector.add(*chunks)) return {};
          }
        }
      }
      return {};
    };
    if (Result<void> done = with_page(page, no_wait, select_page); !done) {
      return tl::unexpected(done.error());
    }
  }
  ChunkSelection selection = collector.finish();
  std::sort(selection.chunks.begin(), selection.chunks.end(), is_before_in_file);
  return selection;
}

Result<ChunkSelection> StoreFile::chunks_for(std::span<const BlockKey> blocks, float low,
                                             float high, const ChunkBudget& budget,
                                             NoWait* no_wait) const {
  ChunkCollector collector(budget);
  for (const BlockKey& key : blocks) {
    const Result<uint32_t> page = page_of(key);
    if (!page) return tl::unexpected(page.error());
    if (!is_active_within(pages_[*page].interval, low, high)) continue;
    if (!collector.begin_page(*page, pages_[*page])) break;
    const auto chunks = with_page(*page, no_wait, [&](const StoreReader& reader) {
      return reader.chunks_for(key, low, high);
    });
    if (!chunks) return tl::unexpected(chunks.error());
    if (!collector.add(*chunks)) break;
  }
  return collector.finish();
}

Result<ChunkSelection> StoreFile::chunks_at(std::span<const ChunkAddress> addresses,
                                            const ChunkBudget& budget, NoWait* no_wait) const {
  ChunkCollector collector(budget);
  for (const ChunkAddress& address : addresses) {
    const Result<uint32_t> page = page_of(address.block);
    if (!page) return tl::unexpected(page.error());
    if (!collector.begin_page(*page, pages_[*page])) break;
    const Result<ChunkRef> found = chunk(address.block, address.band, no_wait);
    if (!found) return tl::unexpected(found.error());
    if (!collector.add({&*found, 1})) break;
  }
  return collector.finish();
}

Result<void> StoreFile::check_within(const ChunkRef& chunk) const {
  if (chunk.offset <= info_.file_bytes && chunk.bytes <= info_.file_bytes - chunk.offset) return {};
  return tl::unexpected(with_file_name(
      {Status::truncated, describe(chunk) + " ends beyond the file: rebuild the store"}));
}

Result<void> StoreFile::check_bytes(const ChunkRef& chunk, std::span<const std::byte> bytes) const {
  const uint32_t found = checksum32(bytes);
  if (found == chunk.checksum) return {};
  return tl::unexpected(with_file_name(checksum_error(describe(chunk), chunk.checksum, found)));
}

Result<void> StoreFile::read_chunk(const ChunkRef& chunk, std::vector<std::byte>& out,
                                   NoWait* no_wait) const {
  if (Result<void> within = check_within(chunk); !within) return within;
  const size_t before = out.size();
  out.resize(before + chunk.bytes);
  const std::span<std::byte> bytes = std::span(out).subspan(before);
  Result<void> result = read(chunk.offset, bytes, no_wait);
  if (result) result = check_bytes(chunk, bytes);
  if (!result) out.resize(before);
  return result;
}

std::vector<ChunkRun> StoreFile::runs_of(std::span<const ChunkRef> chunks) const {
  const uint64_t max_gap = file_.file().max_gap_bytes();
  std::vector<ChunkRun> runs;
  uint64_t begin = 0, end = 0;  // of the last run, in the file
  for (size_t i = 0; i < chunks.size(); ++i) {
    const ChunkRef& chunk = chunks[i];
    const bool is_near = max_gap > 0 && !runs.empty() && chunk.offset >= end &&
                         chunk.offset - end <= max_gap &&
                         chunk.offset + chunk.bytes - begin <= kMaxRunBytes;
    if (is_near) {
      ++runs.back().count;
    } else {
      runs.push_back({i, 1});
      begin = chunk.offset;
    }
    end = chunk.offset + chunk.bytes;
  }
  return runs;
}

Result<void> StoreFile::read_run(std::span<const ChunkRef> run, std::vector<std::byte>& out) const {
  for (const ChunkRef& chunk : run) {
    if (Result<void> within = check_within(chunk); !within) return within;
  }
  const uint64_t begin = run.front().offset;
  out.resize(run.back().offset + run.back().bytes - begin);
  Result<void> result = read(begin, out);
  for (const ChunkRef& chunk : run) {
    if (!result) break;
    result = check_bytes(chunk, std::span(out).subspan(chunk.offset - begin, chunk.bytes));
  }
  return result;
}

}  // namespace isosplat
