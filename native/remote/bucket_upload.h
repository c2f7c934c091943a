#pragma once

#include <functional>
#include <optional>
#include <string>

#include "native/remote/http_client.h"
#include "native/remote/remote_target.h"
#include "shared/system/posix_file/random_access_file.h"

namespace isosplat::remote {

struct UploadOptions {
  std::string content_type = "application/octet-stream";
  std::string cache_control;  ///< empty: none
  /// The bytes of a part, at least 5 MiB (S3's limit). A file of more than 10,000 parts, which S3
  /// refuses, gets larger parts.
  uint64_t part_bytes = uint64_t{16} << 20;
  unsigned threads = 4;  ///< parts that are sent at the same time; each is in memory
  /// Called with the bytes of each part that has arrived, one call at a time.
  std::function<void(uint64_t bytes)> progress;
};

/// Checks that there are credentials. Errors: invalid_argument.
Result<void> check_writable(const RemoteTarget& target);

/// Writes a file of this many bytes to an object of a bucket. The object appears when all bytes
/// have arrived, and then replaces an older one. A file of up to part_bytes is sent in one request,
/// a larger one as a multipart upload. Each request states the SHA-256 of its body, so that the
/// service refuses bytes that were changed on the way. At the end, the length of the object is
/// compared, if the credentials may read it.
///
/// After an error, the multipart upload is aborted, because its parts would cost storage. Errors:
/// those of RandomAccessFile::read(); io_error: see response_error(), and if the file was changed;
/// those of check_writable().
Result<void> upload(HttpClient& client, const RemoteTarget& target, const RandomAccessFile& file,
                    uint64_t bytes, const UploadOptions& options = {});

/// The length of an object; none if there is no such object. Errors: io_error.
Result<std::optional<uint64_t>> object_bytes(HttpClient& client, const RemoteTarget& target);

}  // namespace isosplat::remote
