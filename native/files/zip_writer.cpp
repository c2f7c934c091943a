#include "native/files/zip_writer.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

namespace isosplat {

ZipWriter::ZipWriter(OutputFile& file, Compression compression)
    : file_(file), archive_(archive_write_new(), archive_write_free) {
  archive_write_set_format_zip(archive_.get());
  if (compression == Compression::store) archive_write_zip_set_compression_store(archive_.get());
  // By default, the end of the archive is padded to a multiple of its blocks.
  archive_write_set_bytes_in_last_block(archive_.get(), 1);
  const auto write = [](archive*, void* client, const void* data, size_t size) -> la_ssize_t {
    auto& self = *static_cast<ZipWriter*>(client);
    self.written_ = self.file_.write(self.end_, {static_cast<const std::byte*>(data), size});
    if (!self.written_) return -1;
    self.end_ += size;
    return static_cast<la_ssize_t>(size);
  };
  // Fails only if memory is short; the first entry then fails as well.
  archive_write_open(archive_.get(), this, nullptr, write, nullptr);
}

Result<void> ZipWriter::begin_entry(const char* name, uint64_t size) {
  const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(),
                                                                            archive_entry_free);
  archive_entry_set_pathname(entry.get(), name);
  archive_entry_set_size(entry.get(), static_cast<int64_t>(size));
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  return check(archive_write_header(archive_.get(), entry.get()));
}

Result<void> ZipWriter::append(std::span<const std::byte> bytes) {
  return check(archive_write_data(archive_.get(), bytes.data(), bytes.size()));
}

Result<void> ZipWriter::close() {
  return check(archive_write_close(archive_.get()));
}

Result<void> ZipWriter::check(int64_t returned) {
  if (returned >= 0) return {};
  if (!written_) return written_;
  const char* reason = archive_error_string(archive_.get());
  return fail(Status::io_error,
              fmt::format("{}: cannot write the ZIP archive: {}", file_.temporary_path().string(),
                          reason ? reason : "unknown error"));
}

}  // namespace isosplat
