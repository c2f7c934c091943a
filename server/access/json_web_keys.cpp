#include "server/access/json_web_keys.h"

#include <fmt/format.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/param_build.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace isosplat::server {
namespace {

using Json = nlohmann::json;

template <class T, void (*kFree)(T*)>
struct Free {
  void operator()(T* object) const { kFree(object); }
};
template <class T, void (*kFree)(T*)>
using Owned = std::unique_ptr<T, Free<T, kFree>>;

const unsigned char* bytes_of(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

/// A member that is a string; empty if there is none.
std::string text_of(const Json& object, const char* name) {
  const auto member = object.find(name);
  return member != object.end() && member->is_string() ? member->get<std::string>() : "";
}

/// A public key from these parameters; null if they are invalid.
EVP_PKEY* key_of(const char* type, OSSL_PARAM_BLD* builder) {
  const Owned<OSSL_PARAM, OSSL_PARAM_free> parameters(OSSL_PARAM_BLD_to_param(builder));
  const Owned<EVP_PKEY_CTX, EVP_PKEY_CTX_free> context(
      EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  EVP_PKEY* key = nullptr;
  if (!parameters || !context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY, parameters.get()) != 1) {
    return nullptr;
  }
  return key;
}

EVP_PKEY* rsa_key(std::string_view modulus, std::string_view exponent) {
  constexpr size_t kLeastBytes = 2048 / 8, kMostBytes = 8192 / 8;
  if (modulus.size() < kLeastBytes || modulus.size() > kMostBytes || exponent.empty() ||
      exponent.size() > 8) {
    return nullptr;
  }
  const auto number = [](std::string_view bytes) {
    return Owned<BIGNUM, BN_free>(
        BN_bin2bn(bytes_of(bytes), static_cast<int>(bytes.size()), nullptr));
  };
  const auto n = number(modulus), e = number(exponent);
  const Owned<OSSL_PARAM_BLD, OSSL_PARAM_BLD_free> builder(OSSL_PARAM_BLD_new());
  if (!n || !e || !builder || BN_num_bits(n.get()) < 2048 || !BN_is_odd(e.get()) ||
      BN_is_one(e.get()) ||
      OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, n.get()) != 1 ||
      OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, e.get()) != 1) {
    return nullptr;
  }
  return key_of("RSA", builder.get());
}

EVP_PKEY* p256_key(const std::string& x, const std::string& y) {
  constexpr size_t kCoordinateBytes = 32;
  if (x.size() != kCoordinateBytes || y.size() != kCoordinateBytes) return nullptr;
  const std::string point = "\x04" + x + y;  // uncompressed
  const Owned<OSSL_PARAM_BLD, OSSL_PARAM_BLD_free> builder(OSSL_PARAM_BLD_new());
  if (!builder ||
      OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, "prime256v1", 0) !=
          1 ||
      OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, point.data(),
                                       point.size()) != 1) {
    return nullptr;
  }
  return key_of("EC", builder.get());  // fails if the point is not on the curve
}

/// The signature of ES256, two numbers of 32 bytes, in the DER encoding that OpenSSL expects.
std::string der_of(std::string_view signature) {
  constexpr int kNumberBytes = 32;
  if (signature.size() != 2 * kNumberBytes) return {};
  const Owned<ECDSA_SIG, ECDSA_SIG_free> pair(ECDSA_SIG_new());
  BIGNUM* const r = BN_bin2bn(bytes_of(signature), kNumberBytes, nullptr);
  BIGNUM* const s = BN_bin2bn(bytes_of(signature) + kNumberBytes, kNumberBytes, nullptr);
  if (!pair || !r || !s || ECDSA_SIG_set0(pair.get(), r, s) != 1) {
    BN_free(r);
    BN_free(s);
    return {};
  }
  unsigned char* der = nullptr;
  const int size = i2d_ECDSA_SIG(pair.get(), &der);
  if (size <= 0) return {};
  std::string result(reinterpret_cast<char*>(der), static_cast<size_t>(size));
  OPENSSL_free(der);
  return result;
}

/// The key of an item; `key` is null if it has another purpose.
Result<JsonWebKey> parse_key(const Json& item, size_t number) {
  JsonWebKey key;
  const std::string type = text_of(item, "kty"), algorithm = text_of(item, "alg");
  const bool is_rsa = type == "RSA";
  const bool is_p256 = type == "EC" && text_of(item, "crv") == "P-256";
  const char* const expected = is_rsa ? "RS256" : "ES256";
  const std::string use = text_of(item, "use");
  if ((!is_rsa && !is_p256) || (!algorithm.empty() && algorithm != expected) ||
      (!use.empty() && use != "sig")) {
    return key;
  }
  key.id = text_of(item, "kid");
  key.algorithm = is_rsa ? JwtAlgorithm::rs256 : JwtAlgorithm::es256;
  const auto first = decode_base64url(text_of(item, is_rsa ? "n" : "x"));
  const auto second = decode_base64url(text_of(item, is_rsa ? "e" : "y"));
  if (first && second) key.key.reset(is_rsa ? rsa_key(*first, *second) : p256_key(*first, *second));
  if (key.key) return key;
  return fail(Status::invalid_argument,
              fmt::format("key {}: expected {}", number,
                          is_rsa ? "an RSA key of 2048 to 8192 bits, \"n\" and \"e\""
                                 : "a point of P-256, \"x\" and \"y\""));
}

}  // namespace

bool JsonWebKey::verifies(std::string_view text, std::string_view signature) const {
  const std::string der = algorithm == JwtAlgorithm::es256 ? der_of(signature) : "";
  if (algorithm == JwtAlgorithm::es256) signature = der;
  if (signature.empty()) return false;
  const Owned<EVP_MD_CTX, EVP_MD_CTX_free> context(EVP_MD_CTX_new());
  return context &&
         EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key.get()) == 1 &&
         EVP_DigestVerify(context.get(), bytes_of(signature), signature.size(), bytes_of(text),
                          text.size()) == 1;
}

Result<std::vector<JsonWebKey>> parse_json_web_keys(std::string_view text) {
  constexpr size_t kMaxKeys = 64;
  const Json set = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto items = set.is_object() ? set.find("keys") : set.end();
  if (!set.is_object() || items == set.end() || !items->is_array() || items->size() > kMaxKeys) {
    return fail(Status::invalid_argument,
                fmt::format("expected a JSON Web Key Set: {{\"keys\":[…]}} with at most {} keys",
                            kMaxKeys));
  }
  std::vector<JsonWebKey> keys;
  for (size_t i = 0; i < items->size(); ++i) {
    if (!(*items)[i].is_object()) {
      return fail(Status::invalid_argument, fmt::format("key {}: expected an object", i + 1));
    }
    Result<JsonWebKey> key = parse_key((*items)[i], i + 1);
    if (!key) return tl::unexpected(key.error());
    if (key->key) keys.push_back(std::move(*key));
  }
  if (!keys.empty()) return keys;
  return fail(Status::invalid_argument,
              fmt::format("expected a public key for RS256 or ES256, found none among {} keys",
                          items->size()));
}

std::optional<std::string> decode_base64url(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() * 3 / 4);
  uint32_t bits = 0;
  unsigned count = 0;
  for (const char c : text) {
    uint32_t value = 0;
    if (c >= 'A' && c <= 'Z') {
      value = static_cast<uint32_t>(c - 'A');
    } else if (c >= 'a' && c <= 'z') {
      value = static_cast<uint32_t>(c - 'a') + 26;
    } else if (c >= '0' && c <= '9') {
      value = static_cast<uint32_t>(c - '0') + 52;
    } else if (c == '-' || c == '_') {
      value = c == '-' ? 62 : 63;
    } else {
      return std::nullopt;
    }
    bits = bits << 6 | value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  // Fewer than six bits may remain, and they must be zero. Otherwise several texts would decode to
  // the same bytes.
  if (count >= 6 || (bits & ((1u << count) - 1)) != 0) return std::nullopt;
  return bytes;
}

}  // namespace isosplat::server
