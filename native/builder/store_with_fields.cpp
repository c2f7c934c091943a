#include "native/builder/store_with_fields.h"

#include <algorithm>
#include <set>

#include "native/builder/field_build.h"
#include "native/builder/output_build.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/directory_page.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/format.h"
#include "shared/core/store/store_header.h"

namespace isosplat {
namespace {

constexpr uint64_t kPieceBytes = uint64_t{4} << 20;

/// A temporary file without a name, which is written and then read.
class TemporaryFile : public ByteSink {
 public:
  static Result<TemporaryFile> create(const std::filesystem::path& folder) {
    auto file = PosixFile::create_temporary(folder);
    if (!file) return tl::unexpected(file.error());
    return TemporaryFile(std::make_shared<PosixFile>(std::move(*file)));
  }

  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override {
    bytes_ = std::max(bytes_, offset + bytes.size());
    return file_->write(offset, bytes);
  }

  FileParts parts() const { return {file_, bytes_}; }

 private:
  explicit TemporaryFile(std::shared_ptr<PosixFile> file) : file_(std::move(file)) {}

  std::shared_ptr<PosixFile> file_;
  uint64_t bytes_ = 0;
};

Result<StoreHeader> read_header(const FileParts& file) {
  std::vector<std::byte> bytes(std::min<uint64_t>(kMaxStoreHeaderBytes, file.bytes()));
  if (auto read = file.read(0, bytes); !read) return tl::unexpected(read.error());
  return parse_store_header(bytes);
}

/// Writes the parts of a store after its header, in order.
class Body {
 public:
  Body(ByteSink& sink, uint64_t offset) : sink_(sink), offset_(offset) {}

  Result<void> append(std::span<const std::byte> bytes) {
    if (auto written = sink_.write(offset_, bytes); !written) return written;
    content_.add(bytes);
    offset_ += bytes.size();
    return {};
  }

  Result<void> append(const FileParts& file, uint64_t begin, uint64_t end) {
    std::vector<std::byte> piece;
    for (uint64_t at = begin; at < end; at += piece.size()) {
      piece.resize(std::min(kPieceBytes, end - at));
      if (auto read = file.read(at, piece); !read) return read;
      if (auto appended = append(piece); !appended) return appended;
    }
    return {};
  }

  uint64_t offset() const { return offset_; }
  ContentHash& content() { return content_; }

 private:
  ByteSink& sink_;
  uint64_t offset_;
  ContentHash content_;
};

/// Copies a page whose chunks have moved by `moved` bytes. Sets its offset and checksum.
Result<void> append_page(const FileParts& store, const LevelRef& level, uint64_t moved, Body& body,
                         PageRef& page) {
  std::vector<std::byte> bytes(page.bytes);
  if (auto read = store.read(page.offset, bytes); !read) return read;
  auto parsed = parse_page(bytes, page, level);
  if (!parsed) return tl::unexpected(parsed.error());
  for (DirectoryPage::Block& block : parsed->blocks) {
    if (block.band_count > 0) block.offset += moved;
  }
  bytes = write_page(*parsed);
  page.offset = body.offset();
  page.checksum = checksum32(bytes);
  return body.append(bytes);
}

/// Lists the fields in the header of their store. Errors: invalid_argument, and those of headers.
Result<void> list_fields(std::span<const FileParts> fields, StoreInfo& info) {
  std::set<std::string> names;
  for (const FileParts& field : fields) {
    const auto header = read_header(field);
    if (!header) return tl::unexpected(header.error());
    const FieldInfo& of_field = *header->info.field;
    if (!names.insert(of_field.name).second || names.size() > kMaxFields) {
      return fail(Status::invalid_argument,
                  "fields: expected at most " + std::to_string(kMaxFields) +
                      " with different names, found more, or two with the name '" + of_field.name +
                      "'");
    }
    info.fields.push_back({of_field, 0, field.bytes()});
  }
  return {};
}

using Progress = std::function<void(const BuildProgress&)>;

/// Reports the progress of one of several builds as that of all. The others are assumed to take the
/// same time.
Progress progress_of_stage(const Progress& progress, size_t stage, size_t stages) {
  if (!progress) return {};
  return [=](BuildProgress now) {
    const auto count = static_cast<double>(stages);
    const double left_of_stage = 1 - now.fraction;
    now.fraction = (static_cast<double>(stage) + now.fraction) / count;
    if (left_of_stage > 0) now.seconds_left *= (1 - now.fraction) * count / left_of_stage;
    progress(now);
  };
}

}  // namespace

Result<StoreInfo> write_store_with_fields(const FileParts& store, std::span<const FileParts> fields,
                                          ByteSink& sink) {
  auto header = read_header(store);
  if (!header) return tl::unexpected(header.error());
  StoreInfo& info = header->info;
  const uint32_t old_header_bytes = info.header_bytes;
  if (auto listed = list_fields(fields, info); !listed) return tl::unexpected(listed.error());
  info.header_bytes += static_cast<uint32_t>(field_sections_bytes(info));
  if (info.header_bytes > kMaxStoreHeaderBytes) {
    return fail(Status::invalid_argument,
                "fields: their list does not fit in the header: give them shorter names");
  }
  Body body(sink, info.header_bytes);
  for (size_t i = 0; i < fields.size(); ++i) {
    info.fields[i].offset = body.offset();
    auto appended = body.append(fields[i], 0, fields[i].bytes());
    if (!appended) return tl::unexpected(appended.error());
  }
  const uint64_t moved = body.offset() - old_header_bytes;
  auto copied = body.append(store, old_header_bytes, header->pages.front().offset);
  if (!copied) return tl::unexpected(copied.error());
  for (PageRef& page : header->pages) {
    auto appended = append_page(store, header->levels[page.level], moved, body, page);
    if (!appended) return tl::unexpected(appended.error());
  }
  for (LevelRef& level : header->levels) level.chunks_offset += moved;
  info.file_bytes = body.offset();
  info.content_id = {};
  auto bytes = write_store_header(*header);
  if (!bytes) return tl::unexpected(bytes.error());
  body.content().add(std::span(*bytes).first(bytes->size() - kHeaderChecksumBytes));
  info.content_id = body.content().digest();
  bytes = write_store_header(*header);
  if (auto written = sink.write(0, *bytes); !written) return tl::unexpected(written.error());
  return info;
}

Result<BuildReport> build_store_with_fields(VolumeSource& source,
                                            std::span<const FieldInput> fields, ByteSink& sink,
                                            const std::filesystem::path& target,
                                            const BuildOptions& options) {
  auto base = TemporaryFile::create(options.temporary_folder);
  if (!base) return tl::unexpected(base.error());
  BuildOptions of_base = options;
  of_base.progress = progress_of_stage(options.progress, 0, fields.size() + 1);
  auto report = build_store(source, *base, of_base);
  if (!report) return report;
  const auto store = StoreFile::open(base->parts(), target);
  if (!store) return tl::unexpected(store.error());
  BuildOptions of_field = options;
  of_field.max_error = 0;
  of_field.memory_bytes -= std::min(of_field.memory_bytes, source.resident_bytes());
  std::vector<FileParts> built;
  for (size_t i = 0; i < fields.size(); ++i) {
    const FieldInput& field = fields[i];
    auto opened = field.open();
    if (!opened) return tl::unexpected(opened.error());
    auto file = TemporaryFile::create(options.temporary_folder);
    if (!file) return tl::unexpected(file.error());
    of_field.notes = field.notes;
    of_field.source_file = field.source_file;
    of_field.progress = progress_of_stage(options.progress, i + 1, fields.size() + 1);
    auto written = build_field(**store, field.name, **opened, *file, of_field, field.categories);
    if (!written) return tl::unexpected(written.error());
    built.push_back(file->parts());
  }
  auto info = write_store_with_fields(base->parts(), built, sink);
  if (!info) return tl::unexpected(info.error());
  report->info = std::move(*info);
  return report;
}

Result<BuildReport> build_store_with_fields(VolumeSource& source,
                                            std::span<const FieldInput> fields,
                                            const std::filesystem::path& target,
                                            const BuildOptions& options) {
  return build_output_file(target, options, [&](ByteSink& sink, const BuildOptions& with_folder) {
    return build_store_with_fields(source, fields, sink, target, with_folder);
  });
}

}  // namespace isosplat
