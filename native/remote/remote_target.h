#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "native/remote/transfer.h"

namespace isosplat::remote {

/// Where an object is, and who asks for it.
struct RemoteTarget {
  std::string url;   ///< of an object in a bucket: without parameters
  std::string name;  ///< for messages: the address without user names, passwords and parameters
  std::shared_ptr<const AwsSignature> signature;  ///< null: requests are not signed
};

/// Whether a text is an address of an object: http://…, https://… or s3://….
bool is_address(std::string_view text);

/// Whether a text is an address of an object in a bucket: s3://….
bool is_bucket_address(std::string_view text);

/// The target of an address. s3://BUCKET/KEY is read with the settings of load_aws_settings().
/// `endpoint`: https://HOST of an S3-compatible service; empty: that of the settings, or AWS.
/// Errors: invalid_argument, and those of load_aws_settings().
Result<RemoteTarget> target_of(const std::string& address, const std::string& endpoint);

/// The value of a parameter: all but unreserved characters (RFC 3986) are percent-encoded.
std::string percent_encoded(std::string_view text);

/// A request for the object. `query`: parameters such as "uploads=", sorted by their names and
/// percent-encoded, as their signature requires. The body must live until the request has ended.
HttpRequest request_for(const RemoteTarget& target, std::string method,
                        const std::string& query = {}, std::span<const std::byte> body = {});

}  // namespace isosplat::remote
