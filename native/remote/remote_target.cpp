#include "native/remote/remote_target.h"

#include <curl/curl.h>
#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "native/remote/aws_settings.h"

namespace isosplat::remote {
namespace {

constexpr std::string_view kBucketScheme = "s3://";
constexpr size_t kMaxKeyBytes = 1024;  // S3's limit

struct FreeUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
using Url = std::unique_ptr<CURLU, FreeUrl>;

std::string part_of(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, 0) != CURLUE_OK) return {};
  std::string copy = text;
  curl_free(text);
  return copy;
}

/// Null if the text is no address http://HOST… or https://HOST….
Url parse_url(const std::string& text) {
  Url url(curl_url());
  if (!url || curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) return nullptr;
  const std::string scheme = part_of(url.get(), CURLUPART_SCHEME);
  return scheme == "http" || scheme == "https" ? std::move(url) : nullptr;
}

/// The address without its user name, password, parameters and fragment.
std::string without_secrets(CURLU* url) {
  for (const CURLUPart part :
       {CURLUPART_USER, CURLUPART_PASSWORD, CURLUPART_QUERY, CURLUPART_FRAGMENT}) {
    curl_url_set(url, part, nullptr, 0);
  }
  return part_of(url, CURLUPART_URL);
}

/// Percent-encodes all but unreserved characters (RFC 3986) and those of `kept`.
std::string encode(std::string_view text, std::string_view kept) {
  std::string encoded;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || std::string_view("-._~").find(c) != kept.npos ||
                          kept.find(c) != kept.npos;
    encoded += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return encoded;
}

/// The path of a key, in the form that signatures of S3 need.
std::string encode_key(std::string_view key) {
  return encode(key, "/");
}

/// The rules of AWS, and "_", which older buckets have.
bool is_bucket_name(std::string_view name) {
  return name.size() >= 3 && name.size() <= 63 && std::ranges::all_of(name, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
                  c == '_';
         });
}

/// Whether a path has a part "." or "..", which libcurl and proxies remove.
bool has_dot_part(std::string_view path) {
  while (!path.empty()) {
    const size_t slash = std::min(path.find('/'), path.size());
    const std::string_view part = path.substr(0, slash);
    if (part == "." || part == "..") return true;
    path.remove_prefix(std::min(slash + 1, path.size()));
  }
  return false;
}

/// What an endpoint must not have; null if it is valid. The text itself may contain a password, so
/// messages do not repeat it.
const char* fault_of_endpoint(CURLU* url) {
  if (!url) return "an address that cannot be parsed";
  const auto has = [&](CURLUPart part) { return !part_of(url, part).empty(); };
  if (has(CURLUPART_USER) || has(CURLUPART_PASSWORD)) return "a user name or a password";
  if (has(CURLUPART_QUERY) || has(CURLUPART_FRAGMENT)) return "parameters after '?' or '#'";
  return nullptr;
}

Result<RemoteTarget> bucket_target(const std::string& address, const std::string& endpoint) {
  const std::string_view rest = std::string_view(address).substr(kBucketScheme.size());
  const size_t slash = rest.find('/');
  const std::string bucket(rest.substr(0, slash));
  const std::string_view key =
      slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
  if (bucket.find_first_of("@:") != std::string::npos) {
    // The text may contain a secret key, so it is not repeated.
    return fail(Status::invalid_argument,
                "expected s3://BUCKET/KEY, found a user name, a password or a port in the address: "
                "set credentials with AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY or AWS_PROFILE, "
                "and a host with --endpoint");
  }
  if (!is_bucket_name(bucket) || key.empty() || key.size() > kMaxKeyBytes || has_dot_part(key)) {
    return fail(
        Status::invalid_argument,
        fmt::format("expected s3://BUCKET/KEY, without parts '.' and '..', found '{}'", address));
  }
  const auto settings = load_aws_settings();
  if (!settings) return tl::unexpected(settings.error());
  const std::string& host = endpoint.empty() ? settings->endpoint : endpoint;
  RemoteTarget target{{}, address, settings->signature};
  if (!host.empty()) {
    const Url url = parse_url(host);
    if (const char* found = fault_of_endpoint(url.get())) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected http://HOST or https://HOST of an S3-compatible "
                              "service, found {}",
                              endpoint.empty() ? "AWS_ENDPOINT_URL, or endpoint_url of the profile"
                                               : "--endpoint",
                              found));
    }
    std::string base = part_of(url.get(), CURLUPART_URL);
    while (base.ends_with('/')) base.pop_back();
    target.url = base + "/" + bucket + "/" + encode_key(key);
  } else if (bucket.find_first_of("._") != std::string::npos) {
    // Certificates of AWS do not match names with a point before the host.
    target.url =
        fmt::format("https://s3.{}.amazonaws.com/{}/{}", settings->region, bucket, encode_key(key));
  } else {
    target.url =
        fmt::format("https://{}.s3.{}.amazonaws.com/{}", bucket, settings->region, encode_key(key));
  }
  return target;
}

std::string sha256_of(std::span<const std::byte> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

/// Schemes may be in capitals.
bool has_scheme(std::string_view text, std::string_view scheme) {
  return text.size() >= scheme.size() &&
         std::equal(scheme.begin(), scheme.end(), text.begin(), [](char expected, char found) {
           return expected == std::tolower(static_cast<unsigned char>(found));
         });
}

}  // namespace

std::string percent_encoded(std::string_view text) {
  return encode(text, {});
}

bool is_bucket_address(std::string_view text) {
  return has_scheme(text, kBucketScheme);
}

bool is_address(std::string_view text) {
  return has_scheme(text, "http://") || has_scheme(text, "https://") || is_bucket_address(text);
}

Result<RemoteTarget> target_of(const std::string& address, const std::string& endpoint) {
  if (is_bucket_address(address)) return bucket_target(address, endpoint);
  const Url url = parse_url(address);
  if (!url) {
    // The text may contain a password, so it is not repeated.
    return fail(Status::invalid_argument,
                "expected an address http://HOST/PATH, https://HOST/PATH or s3://BUCKET/KEY, found "
                "an address that cannot be parsed");
  }
  return RemoteTarget{address, without_secrets(url.get()), nullptr};
}

HttpRequest request_for(const RemoteTarget& target, std::string method, const std::string& query,
                        std::span<const std::byte> body) {
  HttpRequest request;
  request.method = std::move(method);
  request.url = query.empty() ? target.url : target.url + "?" + query;
  request.body = body;
  request.signature = target.signature;
  if (target.signature) request.headers.push_back("x-amz-content-sha256: " + sha256_of(body));
  return request;
}

}  // namespace isosplat::remote
