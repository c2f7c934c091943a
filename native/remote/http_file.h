#pragma once

#include <memory>
#include <string>
#include <vector>

#include "native/remote/http_client.h"
#include "native/remote/recent_ranges.h"
#include "native/remote/remote_target.h"
#include "shared/system/posix_file/random_access_file.h"

namespace isosplat::remote {

/// An object of a web server or a bucket, which is read by byte ranges (RFC 9110, section 14). The
/// first 64 KiB, which hold the header of a store, stay in memory, and 64 MiB of what was read
/// last. Of a server without ranges, an object of up to 64 MiB is read as a whole, into memory.
///
/// Every response must have the length and the ETag (or Last-Modified) of the first one, so that
/// all bytes are of one version of the object.
class HttpFile final : public RandomAccessFile {
 public:
  /// Errors: io_error: no response, a status other than 200 or 206, no byte ranges for a larger
  /// object, compressed bytes, a malformed Content-Range.
  static Result<std::shared_ptr<const HttpFile>> open(std::shared_ptr<HttpClient> client,
                                                      RemoteTarget target);

  uint64_t bytes() const { return bytes_; }

  const std::string& name() const override { return target_.name; }
  Result<FileIdentity> identity(NoWait* no_wait = nullptr) const override;
  /// Also io_error if the object was changed after it was opened.
  Result<void> read(uint64_t offset, std::span<std::byte> out,
                    NoWait* no_wait = nullptr) const override;
  /// About what a connection of 100 Mbit/s transfers in 5 ms.
  uint64_t max_gap_bytes() const override { return uint64_t{64} << 10; }

 private:
  HttpFile(std::shared_ptr<HttpClient> client, RemoteTarget target)
      : client_(std::move(client)), target_(std::move(target)) {}

  Result<void> read_first();
  Result<HttpResponse> request(uint64_t offset, uint64_t count, uint64_t max_bytes) const;
  Result<void> check_unchanged(const HttpResponse& response, uint64_t bytes) const;
  tl::unexpected<Error> failed(const std::string& why) const;

  std::shared_ptr<HttpClient> client_;
  RemoteTarget target_;
  uint64_t bytes_ = 0;
  std::string version_;           // of the first response: ETag, or Last-Modified
  std::vector<std::byte> first_;  // the beginning, or all bytes
  mutable RecentRanges recent_{uint64_t{64} << 20};
};

}  // namespace isosplat::remote
