#include "native/remote/bucket_upload.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <exception>
#include <mutex>
#include <new>
#include <random>
#include <thread>

namespace isosplat::remote {
namespace {

constexpr uint64_t kMaxParts = 10'000;
constexpr uint64_t kMaxResponseBytes = 64 * 1024;
constexpr unsigned kContentAttempts = 12;  // to send a part: a network may be gone for 2 minutes
// S3 may assemble the parts for minutes. Meanwhile it sends a few bytes, or none.
constexpr unsigned kCompleteStall_s = 600;
constexpr size_t kMaxIdBytes = 2048;  // of an upload's id, and of a part's ETag
constexpr std::string_view kMarkHeader = "x-amz-meta-isosplat-upload";

uint64_t part_bytes_for(uint64_t bytes, uint64_t preferred) {
  return std::max(preferred, (bytes + kMaxParts - 1) / kMaxParts);
}

/// Distinguishes this upload from others of the same object.
std::string new_mark() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

/// Whether a text of the service can be sent back to it in a header and in XML.
bool is_plain(std::string_view text) {
  return !text.empty() && text.size() <= kMaxIdBytes && std::ranges::all_of(text, [](char c) {
    return c > ' ' && c < 127 && c != '<' && c != '&';
  });
}

/// Fails if the file has another identity than at the beginning. Errors: io_error.
Result<void> check_unchanged(const RandomAccessFile& file, const FileIdentity& before) {
  const auto now = file.identity();
  if (!now) return tl::unexpected(now.error());
  if (now->has_same_content(before)) return {};
  return fail(
      Status::io_error,
      fmt::format("{}: the file was changed while it was sent: send it again", file.name()));
}

/// Calls f(), which returns Result<void>. An exception becomes an error.
template <class F>
Result<void> without_exceptions(const std::string& name, F f) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    return fail(Status::io_error, name + ": out of memory while it was sent: close other programs");
  } catch (const std::exception& error) {
    return fail(Status::io_error, fmt::format("{}: cannot be sent: {}", name, error.what()));
  }
}

/// One multipart upload.
class Multipart {
 public:
  Multipart(HttpClient& client, const RemoteTarget& target, const RandomAccessFile& file,
            uint64_t bytes, const UploadOptions& options)
      : client_(client),
        target_(target),
        file_(file),
        bytes_(bytes),
        options_(options),
        part_bytes_(part_bytes_for(bytes, options.part_bytes)),
        tags_((bytes + part_bytes_ - 1) / part_bytes_) {}

  Result<void> run(const std::vector<std::string>& headers, const FileIdentity& identity) {
    if (auto begun = begin(headers); !begun) return begun;
    auto sent = send_parts();
    if (sent) sent = check_unchanged(file_, identity);
    if (sent) sent = without_exceptions(target_.name, [&] { return complete(); });
    return sent ? sent : abort(std::move(sent.error()));
  }

 private:
  /// If the response to an attempt is lost, an upload without parts remains, which costs nothing.
  Result<void> begin(const std::vector<std::string>& headers) {
    HttpRequest request = request_for(target_, "POST", "uploads=");
    request.headers.insert(request.headers.end(), headers.begin(), headers.end());
    request.headers.push_back(fmt::format("{}: {}", kMarkHeader, mark_));
    request.max_bytes = kMaxResponseBytes;
    const auto response = client_.send(request, target_.name);
    if (!response) return tl::unexpected(response.error());
    if (response->status != 200) return failed(*response, "beginning the upload");
    id_ = element_text(response->text(), "UploadId", kMaxIdBytes + 1);
    if (is_plain(id_)) return {};
    return fail(Status::io_error,
                fmt::format("{}: expected the id of an upload, found none: check --endpoint",
                            target_.name));
  }

  Result<void> send_part(size_t index) {
    const uint64_t offset = index * part_bytes_;
    std::vector<std::byte> body(std::min(part_bytes_, bytes_ - offset));
    if (auto read = file_.read(offset, body); !read) return read;
    const std::string query =
        fmt::format("partNumber={}&uploadId={}", index + 1, percent_encoded(id_));
    HttpRequest request = request_for(target_, "PUT", query, body);
    request.headers.emplace_back("Content-Type: application/octet-stream");
    request.max_bytes = kMaxResponseBytes;
    request.attempts = kContentAttempts;
    const auto response = client_.send(request, target_.name);
    if (!response) return tl::unexpected(response.error());
    const std::string tag = response->header("etag");
    if (response->status != 200 || !is_plain(tag)) {
      return failed(*response, fmt::format("sending part {} of {}", index + 1, tags_.size()));
    }
    tags_[index] = tag;
    if (options_.progress) {
      const std::scoped_lock lock(mutex_);
      options_.progress(body.size());
    }
    return {};
  }

  /// Sends all parts, several at the same time. Returns the first error.
  Result<void> send_parts() {
    std::atomic<size_t> next{0};
    Result<void> result;
    const auto work = [&] {
      for (size_t i = next++; i < tags_.size(); i = next++) {
        auto sent = without_exceptions(target_.name, [&] { return send_part(i); });
        if (sent) continue;
        next = tags_.size();
        const std::scoped_lock lock(mutex_);
        if (result) result = std::move(sent);
      }
    };
    {
      std::vector<std::jthread> threads;
      try {
        for (size_t i = 1; i < std::min<size_t>(options_.threads, tags_.size()); ++i) {
          threads.emplace_back(work);
        }
      } catch (const std::exception&) {
        // The threads that could be started send all parts.
      }
      work();
    }
    return result;
  }

  Result<void> complete() {
    std::string xml = "<CompleteMultipartUpload>";
    for (size_t i = 0; i < tags_.size(); ++i) {
      xml +=
          fmt::format("<Part><PartNumber>{}</PartNumber><ETag>{}</ETag></Part>", i + 1, tags_[i]);
    }
    xml += "</CompleteMultipartUpload>";
    HttpRequest request = request_for(target_, "POST", "uploadId=" + percent_encoded(id_),
                                      std::as_bytes(std::span(xml)));
    request.headers.emplace_back("Content-Type: application/xml");
    request.max_bytes = kMaxResponseBytes;
    request.stall_s = kCompleteStall_s;
    const auto response = client_.send(request, target_.name);
    // The service may find an error after it has sent the status 200.
    if (response && response->status == 200 &&
        response->text().find("<Error>") == std::string_view::npos) {
      return {};
    }
    // If only responses were lost, the upload is complete. The status of another attempt is then
    // 404, or others.
    if (has_mark()) return {};
    if (!response) return tl::unexpected(response.error());
    return failed(*response, "completing the upload");
  }

  bool has_mark() {
    const auto response = client_.send(request_for(target_, "HEAD"), target_.name);
    return response && response->status == 200 && response->header(kMarkHeader) == mark_;
  }

  Result<void> abort(Error error) {
    const HttpRequest request = request_for(target_, "DELETE", "uploadId=" + percent_encoded(id_));
    const auto response = client_.send(request, target_.name);
    const bool is_gone = response && (response->status < 300 || response->status == 404);
    if (!is_gone) {
      error.message +=
          "; the parts that were sent remain in the bucket until a lifecycle rule or aws s3api "
          "abort-multipart-upload removes them";
    }
    return tl::unexpected(std::move(error));
  }

  tl::unexpected<Error> failed(const HttpResponse& response, const std::string& action) const {
    return tl::unexpected(response_error(response, target_, action));
  }

  HttpClient& client_;
  const RemoteTarget& target_;
  const RandomAccessFile& file_;
  const uint64_t bytes_;
  const UploadOptions& options_;
  const uint64_t part_bytes_;
  const std::string mark_ = new_mark();
  std::string id_;
  std::vector<std::string> tags_;  // ETags of the parts
  std::mutex mutex_;
};

Result<void> put_whole(HttpClient& client, const RemoteTarget& target, const RandomAccessFile& file,
                       uint64_t bytes, const UploadOptions& options,
                       const std::vector<std::string>& headers, const FileIdentity& identity) {
  std::vector<std::byte> body(bytes);
  if (auto read = file.read(0, body); !read) return read;
  if (auto checked = check_unchanged(file, identity); !checked) return checked;
  HttpRequest request = request_for(target, "PUT", {}, body);
  request.headers.insert(request.headers.end(), headers.begin(), headers.end());
  request.max_bytes = kMaxResponseBytes;
  request.attempts = kContentAttempts;
  const auto response = client.send(request, target.name);
  if (!response) return tl::unexpected(response.error());
  if (response->status != 200) {
    return tl::unexpected(response_error(*response, target, "writing"));
  }
  if (options.progress) options.progress(bytes);
  return {};
}

/// The error of a HEAD request. The cause is in the body of the response to GET.
Error head_error(HttpClient& client, const RemoteTarget& target, const HttpResponse& head) {
  HttpRequest request = request_for(target, "GET");
  request.headers.emplace_back("Range: bytes=0-0");
  const auto response = client.send(request, target.name);
  const bool has_failed = response && response->status >= 300;
  return response_error(has_failed ? *response : head, target, "reading its length");
}

}  // namespace

Result<std::optional<uint64_t>> object_bytes(HttpClient& client, const RemoteTarget& target) {
  const auto response = client.send(request_for(target, "HEAD"), target.name);
  if (!response) return tl::unexpected(response.error());
  if (response->status == 404) return std::nullopt;
  if (response->status != 200) return tl::unexpected(head_error(client, target, *response));
  const std::string text = response->header("content-length");
  uint64_t bytes = 0;
  std::from_chars(text.data(), text.data() + text.size(), bytes);
  return bytes;
}

Result<void> check_writable(const RemoteTarget& target) {
  if (target.signature) return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected credentials for writing, found none: set "
                          "AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or AWS_PROFILE",
                          target.name));
}

Result<void> upload(HttpClient& client, const RemoteTarget& target, const RandomAccessFile& file,
                    uint64_t bytes, const UploadOptions& options) {
  if (auto checked = check_writable(target); !checked) return checked;
  std::vector<std::string> headers = {"Content-Type: " + options.content_type};
  if (!options.cache_control.empty()) {
    headers.push_back("Cache-Control: " + options.cache_control);
  }
  const auto identity = file.identity();
  if (!identity) return tl::unexpected(identity.error());
  auto sent = without_exceptions(target.name, [&] {
    return bytes <= options.part_bytes
               ? put_whole(client, target, file, bytes, options, headers, *identity)
               : Multipart(client, target, file, bytes, options).run(headers, *identity);
  });
  if (!sent) return sent;
  const auto written = object_bytes(client, target);
  // The service has accepted all bytes. Credentials may have the right to write only.
  if (!written || *written == bytes) return {};
  return fail(Status::io_error,
              fmt::format("{}: expected an object of {} bytes after the upload, found {}: send it "
                          "again",
                          target.name, bytes, written->value_or(0)));
}

}  // namespace isosplat::remote
