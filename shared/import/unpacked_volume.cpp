#include "shared/import/unpacked_volume.h"

#include <fmt/format.h>
#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

#include "shared/import/volume/opened_volume.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::import {
namespace {

constexpr size_t kPiece = 1 << 20;
/// Number of bytes that are written before the beginning is checked.
constexpr uint64_t kBeginning = 64 << 10;
/// The share of the free space that stays free.
constexpr double kLeftFree = 0.1;

/// An unlinked file, with a symbolic link to it in a separate folder, since readers choose by
/// names. After a crash, only a dangling link remains.
class TemporaryFile {
 public:
  static Result<std::unique_ptr<TemporaryFile>> create(const std::filesystem::path& name) {
    std::error_code error;
    const auto parent = std::filesystem::temp_directory_path(error);
    auto file = PosixFile::create_temporary(error ? "/tmp" : parent);
    if (!file) return tl::unexpected(file.error());
    std::string folder = ((error ? "/tmp" : parent) / "isosplat-XXXXXX").string();
    if (!::mkdtemp(folder.data())) {
      return fail(Status::io_error, fmt::format("{}: a temporary folder cannot be created: {}: set "
                                                "TMPDIR to a folder that can be written to",
                                                folder, std::generic_category().message(errno)));
    }
    auto made = std::unique_ptr<TemporaryFile>(new TemporaryFile(std::move(*file), folder, name));
    std::filesystem::create_symlink(fmt::format("/proc/self/fd/{}", made->file_.descriptor()),
                                    made->path(), error);
    if (!error) return made;
    return fail(Status::io_error,
                fmt::format("{}: cannot be created: {}", made->path().string(), error.message()));
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path(), ignored);
    std::filesystem::remove(folder_, ignored);
  }

  std::filesystem::path path() const { return folder_ / name_; }

  /// Appends bytes. Errors: io_error.
  Result<void> append(std::span<const std::byte> bytes) {
    std::error_code unknown;
    const auto space = std::filesystem::space(folder_, unknown);
    if (!unknown && static_cast<double>(bytes.size()) >
                        static_cast<double>(space.available) * (1 - kLeftFree)) {
      return fail(Status::io_error,
                  fmt::format("{}: expected space for the unpacked file, found that {} bytes are "
                              "not enough: set TMPDIR to a folder with more, or unpack the file "
                              "yourself",
                              folder_.parent_path().string(), size_ + space.available));
    }
    if (auto written = file_.write(size_, bytes); !written) return written;
    size_ += bytes.size();
    return {};
  }

 private:
  TemporaryFile(PosixFile file, std::filesystem::path folder, std::filesystem::path name)
      : file_(std::move(file)), folder_(std::move(folder)), name_(std::move(name)) {}

  PosixFile file_;
  std::filesystem::path folder_, name_;
  uint64_t size_ = 0;
};

/// Replaces the path of the temporary file in a text by the path of the compressed file.
std::string renamed(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

class UnpackedSource : public VolumeSource {
 public:
  UnpackedSource(std::unique_ptr<VolumeSource> source, std::unique_ptr<TemporaryFile> file,
                 std::filesystem::path packed)
      : file_(std::move(file)), source_(std::move(source)), packed_(std::move(packed)) {}

  const VolumeHeader& header() const override { return source_->header(); }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return named(source_->read_slices(first, count, out));
  }

  bool reads_rows() const override { return source_->reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    return named(source_->read_rows(part, out));
  }

  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return {packed_}; }

 private:
  /// An error names the compressed file.
  Result<void> named(Result<void> read) const {
    return std::move(read).map_error([&](const Error& error) {
      return Error{error.status, renamed(error.message, file_->path().string(), packed_.string())};
    });
  }

  std::unique_ptr<TemporaryFile> file_;  // removed after its source is closed
  std::unique_ptr<VolumeSource> source_;
  std::filesystem::path packed_;
};

}  // namespace

Result<OpenVolume> open_unpacked(const std::filesystem::path& path, Packing packing,
                                 const UnpackedOpener& opener) {
  auto stream = open_unpack_stream(path, packing);
  if (!stream) return tl::unexpected(stream.error());
  auto file = TemporaryFile::create(unpacked_name(path));
  if (!file) return tl::unexpected(file.error());
  const auto named = [&](const Error& error) {
    return tl::unexpected(
        Error{error.status, renamed(error.message, (*file)->path().string(), path.string())});
  };
  std::vector<std::byte> piece(kPiece);
  for (bool is_first = true;; is_first = false) {
    const auto room = std::span(piece).first(is_first ? kBeginning : kPiece);
    const auto got = (*stream)->read_some(room);
    if (!got) return tl::unexpected(got.error());
    if (auto written = (*file)->append(room.first(*got)); !written) {
      return tl::unexpected(written.error());
    }
    if (is_first) {
      if (auto fine = opener.check((*file)->path()); !fine) return named(fine.error());
    }
    if (*got < room.size()) break;
  }
  auto volume = opener.open((*file)->path());
  if (!volume) return named(volume.error());
  for (std::string& note : volume->notes) {
    note = renamed(std::move(note), (*file)->path().string(), path.string());
  }
  volume->source =
      std::make_unique<UnpackedSource>(std::move(volume->source), std::move(*file), path);
  return volume;
}

}  // namespace isosplat::import
