#include "native/cli/bucket_output.h"

#include <fmt/format.h>

#include <algorithm>
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

/// A text as one word of a shell.
std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
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
  output.client_ = std::make_unique<remote::HttpClient>(output.options_.http);
  auto made = UploadFolder::create(folder);
  if (!made) return tl::unexpected(made.error());
  output.file_ = made->path() / name;
  output.folder_ = std::move(*made);
  return output;
}

Result<void> BucketOutput::check_replaceable(const std::string& source_path_hash) const {
  const auto target = remote::target_of(address_, options_.endpoint);
  if (!target) return tl::unexpected(target.error());
  const auto exists = remote::object_bytes(*client_, *target);
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

Result<uint64_t> BucketOutput::send(const fs::path& path, const std::string& address,
                                    std::string type) {
  const auto target = remote::target_of(address, options_.endpoint);
  if (!target) return tl::unexpected(target.error());
  const auto file = PosixFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  ProgressLine line(fmt::format("Sending {}", path.filename().string()));
  uint64_t sent = 0;
  remote::UploadOptions options;
  options.content_type = std::move(type);
  options.progress = [&](uint64_t bytes) {
    sent += bytes;
    line.show(
        static_cast<double>(sent) / static_cast<double>(std::max<uint64_t>(identity->bytes, 1)),
        format_bytes(sent));
  };
  auto uploaded = remote::upload(*client_, *target, *file, identity->bytes, options);
  line.clear();
  if (!uploaded) return tl::unexpected(uploaded.error());
  return identity->bytes;
}

Error BucketOutput::kept(Error error) {
  const fs::path file = folder_.keep() / file_.filename();
  const std::string endpoint =
      options_.endpoint.empty() ? "" : " --endpoint-url " + shell_word(options_.endpoint);
  error.message += fmt::format("; the finished file is kept: aws s3 cp {} {}{} uploads it",
                               shell_word(file.string()), shell_word(address_), endpoint);
  return error;
}

Result<void> BucketOutput::check_thumbnail(const std::string& address) const {
  const auto target = remote::target_of(address, options_.endpoint);
  if (!target) return tl::unexpected(target.error());
  const auto exists = remote::object_bytes(*client_, *target);
  if (!exists) return tl::unexpected(exists.error());
  if (!*exists) return {};
  const auto object = remote::open_object(address, options_);
  if (!object) return tl::unexpected(object.error());
  if (!server::thumbnail_content(**object).empty()) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected no object, or a thumbnail, found another object: move it "
                          "away, or replace it with --force",
                          address));
}

Result<uint64_t> BucketOutput::publish(bool force) {
  const auto sent = send(file_, address_, "application/octet-stream");
  if (!sent) return tl::unexpected(kept(sent.error()));
  const fs::path picture = server::thumbnail_path(file_);
  std::error_code ignored;
  if (fs::exists(picture, ignored)) {
    // The store is complete without its picture.
    const std::string address = server::thumbnail_path(address_).string();
    auto drawn = force ? Result<void>() : check_thumbnail(address);
    if (drawn) {
      drawn = send(picture, address, "image/webp").map([](uint64_t) {});
    }
    if (!drawn) note("no thumbnail: " + drawn.error().message);
  }
  return *sent;
}

}  // namespace isosplat::cli
