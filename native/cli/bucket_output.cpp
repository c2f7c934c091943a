#include "native/cli/bucket_output.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <array>
#include <system_error>
#include <utility>

#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/remote/bucket_upload.h"
#include "server/catalog/thumbnail.h"
#include "shared/core/scene/bundle_header.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

Result<fs::path> make_folder(const fs::path& parent) {
  std::error_code error;
  const fs::path folder = parent.empty() ? fs::temp_directory_path(error) : parent;
  std::string name = (folder / "isosplat-upload-XXXXXX").string();
  if (!error && ::mkdtemp(name.data())) return fs::path(name);
  return fail(Status::io_error,
              fmt::format("{}: cannot make a folder for the file before it is uploaded: give "
                          "another folder with --temporary-folder",
                          folder.string()));
}

}  // namespace

Result<BucketOutput> BucketOutput::create(const std::string& address, const RemoteFlags& flags,
                                          const fs::path& folder) {
  BucketOutput output;
  output.address_ = address;
  output.options_ = flags.options();
  auto target = remote::target_of(address, output.options_.endpoint);
  if (!target) return tl::unexpected(target.error());
  // Before a build that may take hours.
  if (auto checked = remote::check_writable(*target); !checked) {
    return tl::unexpected(checked.error());
  }
  const std::string name = address.substr(address.rfind('/') + 1);
  if (name.empty() || name == "." || name == "..") {
    return fail(Status::invalid_argument,
                fmt::format("-o: expected s3://BUCKET/KEY, the key ending with the name of a file, "
                            "found '{}'",
                            address));
  }
  auto thumbnail =
      remote::target_of(server::thumbnail_path(address).string(), output.options_.endpoint);
  if (!thumbnail) return tl::unexpected(thumbnail.error());
  output.target_ = std::move(*target);
  output.thumbnail_ = std::move(*thumbnail);
  output.client_ = std::make_unique<remote::HttpClient>(output.options_.http);
  auto made = make_folder(folder);
  if (!made) return tl::unexpected(made.error());
  output.file_ = *made / name;
  output.folder_.reset(new fs::path(std::move(*made)));
  return output;
}

void BucketOutput::RemoveFolder::operator()(const fs::path* folder_to_remove) const {
  std::error_code ignored;
  fs::remove_all(*folder_to_remove, ignored);
  delete folder_to_remove;
}

Result<void> BucketOutput::check_replaceable(const std::string& source_path_hash) const {
  const auto exists = remote::object_bytes(*client_, target_);
  if (!exists) return tl::unexpected(exists.error());
  if (!*exists) return {};
  const auto bytes = remote::open_remote(address_, options_);
  if (!bytes) return tl::unexpected(bytes.error());
  std::array<std::byte, kBundlePrefixBytes> prefix{};
  const bool has_prefix = bytes->bytes() >= prefix.size() && bytes->read(0, prefix);
  if (file_.extension() == ".isobundle" && has_prefix && is_bundle(prefix)) return {};
  const auto store = StoreFile::open(*bytes, address_);
  if (store && source_of(**store).path_hash == source_path_hash) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected no object, or a store of the same volume, found {}: give "
                          "another key with -o, or replace it with --force",
                          address_, store ? "a store of another volume" : "another object"));
}

Result<void> BucketOutput::send(const PosixFile& file, const remote::RemoteTarget& target,
                                std::string type) {
  const auto identity = file.identity();
  if (!identity) return tl::unexpected(identity.error());
  ProgressLine line(fmt::format("Sending {}", file_.filename().string()));
  uint64_t sent = 0;
  remote::UploadOptions options;
  options.content_type = std::move(type);
  options.progress = [&](uint64_t bytes) {
    sent += bytes;
    line.show(
        static_cast<double>(sent) / static_cast<double>(std::max<uint64_t>(identity->bytes, 1)),
        format_bytes(sent));
  };
  auto uploaded = remote::upload(*client_, target, file, identity->bytes, options);
  line.clear();
  return uploaded;
}

Result<uint64_t> BucketOutput::publish() {
  const auto file = PosixFile::open(file_);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  const auto thumbnail = PosixFile::open(server::thumbnail_path(file_));
  folder_.reset();
  if (auto sent = send(*file, target_, "application/octet-stream"); !sent) {
    return tl::unexpected(sent.error());
  }
  if (thumbnail) {
    // The store is complete without its picture.
    if (auto sent = send(*thumbnail, thumbnail_, "image/png"); !sent) {
      note("no thumbnail: " + sent.error().message);
    }
  }
  return identity->bytes;
}

}  // namespace isosplat::cli
