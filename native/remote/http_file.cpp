#include "native/remote/http_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace isosplat::remote {
namespace {

constexpr uint64_t kFirstBytes = uint64_t{64} << 10;
constexpr uint64_t kMaxWholeBytes = uint64_t{64} << 20;

struct ContentRange {
  uint64_t first = 0, last = 0, all = 0;
};

/// Parses "bytes FIRST-LAST/ALL". None if it is anything else.
std::optional<ContentRange> parse_content_range(std::string_view text) {
  ContentRange range;
  const auto take = [&](std::string_view before, uint64_t& number) {
    if (!text.starts_with(before)) return false;
    text.remove_prefix(before.size());
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    return true;
  };
  const bool is_valid = take("bytes ", range.first) && take("-", range.last) &&
                        take("/", range.all) && text.empty() && range.first <= range.last &&
                        range.last < range.all;
  return is_valid ? std::optional(range) : std::nullopt;
}

std::string version_of(const HttpResponse& response) {
  const std::string tag = response.header("etag");
  return tag.empty() ? response.header("last-modified") : tag;
}

}  // namespace

tl::unexpected<Error> HttpFile::failed(const std::string& why) const {
  return fail(Status::io_error, target_.name + ": " + why);
}

Result<std::shared_ptr<const HttpFile>> HttpFile::open(std::shared_ptr<HttpClient> client,
                                                       RemoteTarget target) {
  std::shared_ptr<HttpFile> file(new HttpFile(std::move(client), std::move(target)));
  if (auto read = file->read_first(); !read) return tl::unexpected(read.error());
  return std::shared_ptr<const HttpFile>(std::move(file));
}

Result<HttpResponse> HttpFile::request(uint64_t offset, uint64_t count, uint64_t max_bytes) const {
  HttpRequest request = request_for(target_, "GET");
  request.headers.push_back(fmt::format("Range: bytes={}-{}", offset, offset + count - 1));
  request.max_bytes = max_bytes;
  request.max_range_bytes = count;
  auto response = client_->send(request, target_.name);
  if (!response) return response;
  const std::string encoding = response->header("content-encoding");
  if (!encoding.empty() && encoding != "identity" && response->status < 300) {
    return failed(
        fmt::format("expected the bytes of the object, found Content-Encoding: {}: turn "
                    "off compression for stores on this server",
                    encoding));
  }
  return response;
}

Result<void> HttpFile::read_first() {
  auto response = request(0, kFirstBytes, kMaxWholeBytes);
  if (!response) return tl::unexpected(response.error());
  version_ = version_of(*response);
  if (response->status == 416) return {};  // an empty object has no ranges
  if (response->status == 200) {
    if (response->is_cut) {
      return failed(
          fmt::format("expected a server that supports byte ranges (status 206), found status 200 "
                      "with more than {} bytes: choose another host, or download the object",
                      kMaxWholeBytes));
    }
    bytes_ = response->body.size();
    first_ = std::move(response->body);
    return {};
  }
  if (response->status != 206) {
    return tl::unexpected(response_error(*response, target_, "reading"));
  }
  const auto range = parse_content_range(response->header("content-range"));
  if (!range || range->first != 0 || range->last != std::min(kFirstBytes, range->all) - 1 ||
      response->body.size() != range->last + 1 || response->is_cut) {
    return failed(
        fmt::format("expected the first {} bytes, found {}{} bytes and Content-Range '{}': "
                    "check the server",
                    kFirstBytes, response->is_cut ? "more than " : "", response->body.size(),
                    response->header("content-range")));
  }
  bytes_ = range->all;
  first_ = std::move(response->body);
  return {};
}

Result<FileIdentity> HttpFile::identity(NoWait*) const {
  return FileIdentity{.bytes = bytes_};
}

Result<void> HttpFile::check_unchanged(const HttpResponse& response, uint64_t bytes) const {
  const std::string version = version_of(response);
  if (bytes == bytes_ && version == version_) return {};
  const auto describe = [](uint64_t size, const std::string& tag) {
    return fmt::format("{} bytes{}{}", size, tag.empty() ? "" : ", version ", tag);
  };
  return failed(fmt::format(
      "the object was changed while it was read: expected {}, found {}: run the command again",
      describe(bytes_, version_), describe(bytes, version)));
}

Result<void> HttpFile::read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const {
  if (offset > bytes_ || out.size() > bytes_ - offset) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} bytes at {}, found {} bytes in all: copy it again",
                            target_.name, out.size(), offset, bytes_));
  }
  if (offset + out.size() <= first_.size()) {
    std::copy_n(first_.begin() + static_cast<ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  }
  if (recent_.read(offset, out)) return {};
  if (no_wait) {
    no_wait->needs_disk = true;
    return failed("cannot be read without waiting for the network");
  }
  auto response = request(offset, out.size(), out.size());
  if (!response) return tl::unexpected(response.error());
  const auto range = parse_content_range(response->header("content-range"));
  if (response->status == 200 || response->status == 416 || (response->status == 206 && range)) {
    uint64_t all = range ? range->all : bytes_;
    if (response->status == 200) {
      const std::string length = response->header("content-length");
      std::from_chars(length.data(), length.data() + length.size(), all);
    }
    if (auto checked = check_unchanged(*response, all); !checked) return checked;
  }
  if (response->status != 206 && response->status != 200) {
    return tl::unexpected(response_error(*response, target_, "reading"));
  }
  if (response->status == 200 || !range || range->first != offset ||
      range->last != offset + out.size() - 1 || response->body.size() != out.size() ||
      response->is_cut) {
    return failed(
        fmt::format("expected {} bytes at {} (status 206), found status {} with {}{} bytes "
                    "and Content-Range '{}': check the server",
                    out.size(), offset, response->status, response->is_cut ? "more than " : "",
                    response->body.size(), response->header("content-range")));
  }
  std::copy(response->body.begin(), response->body.end(), out.begin());
  recent_.add(offset, std::move(response->body));
  return {};
}

}  // namespace isosplat::remote
