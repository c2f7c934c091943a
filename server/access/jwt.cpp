#include "server/access/jwt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/access/json_web_keys.h"

namespace isosplat::server {
namespace {

using Json = nlohmann::json;

tl::unexpected<Error> refused(const char* message) {
  return fail(Status::invalid_argument, message);
}

/// The JSON object in a part of a token; null if there is none.
Json object_in(std::string_view part) {
  const auto text = decode_base64url(part);
  if (!text) return nullptr;
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  return json.is_object() ? json : Json(nullptr);
}

std::string text_of(const Json& object, const std::string& name) {
  const auto member = object.find(name);
  return member != object.end() && member->is_string() ? member->get<std::string>() : "";
}

/// A time in seconds since 1970; no value if it is missing, and NaN if it is not a number.
std::optional<double> time_of(const Json& claims, const char* name) {
  const auto member = claims.find(name);
  if (member == claims.end()) return std::nullopt;
  return member->is_number() ? member->get<double>() : std::nan("");
}

bool has_audience(const Json& claims, const std::string& audience) {
  const auto member = claims.find("aud");
  if (member == claims.end()) return false;
  if (!member->is_array()) return *member == audience;
  return std::ranges::any_of(*member, [&](const Json& item) { return item == audience; });
}

/// Names are compared with the patterns of rules, and written to logs.
bool is_name(const std::string& text) {
  constexpr size_t kMaxName = 256;
  return !text.empty() && text.size() <= kMaxName &&
         std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

std::vector<std::string> groups_of(const Json& claims, const std::string& claim) {
  constexpr size_t kMaxGroups = 256;
  std::vector<std::string> groups;
  const auto add = [&](const Json& item) {
    if (!item.is_string() || groups.size() == kMaxGroups) return;
    if (is_name(item.get_ref<const std::string&>())) groups.push_back(item.get<std::string>());
  };
  const auto member = claims.find(claim);
  if (member == claims.end()) return groups;
  if (member->is_array()) {
    std::ranges::for_each(*member, add);
  } else {
    add(*member);
  }
  return groups;
}

}  // namespace

struct JwtVerifier::State {
  struct Valid {
    Identity identity;
    double from, until;
  };

  Result<Valid> check(std::string_view token, uint64_t now) const;
  bool is_signed(const Json& header, std::string_view text, std::string_view signature) const;

  JwtOptions options;
  std::vector<JsonWebKey> keys;
  mutable std::mutex mutex;
  std::unordered_map<std::string, Valid> known;  ///< by token; guarded by mutex
};

JwtVerifier::JwtVerifier(std::unique_ptr<State> state) : state_(std::move(state)) {}
JwtVerifier::~JwtVerifier() = default;

Result<std::shared_ptr<const JwtVerifier>> JwtVerifier::create(std::string_view keys,
                                                               JwtOptions options) {
  if (options.audience.empty()) {
    return refused("tokens of an identity provider: expected the audience that they must name");
  }
  Result<std::vector<JsonWebKey>> parsed = parse_json_web_keys(keys);
  if (!parsed) return tl::unexpected(parsed.error());
  auto state = std::make_unique<State>();
  state->options = std::move(options);
  state->keys = std::move(*parsed);
  return std::shared_ptr<const JwtVerifier>(new JwtVerifier(std::move(state)));
}

bool JwtVerifier::is_jwt(std::string_view token) {
  return token.size() <= kMaxBytes && std::ranges::count(token, '.') == 2;
}

/// Whether a key of the set has signed `text`. The key determines the algorithm; that of the header
/// must be equal.
bool JwtVerifier::State::is_signed(const Json& header, std::string_view text,
                                   std::string_view signature) const {
  const std::string algorithm = text_of(header, "alg"), id = text_of(header, "kid");
  const bool has_id = header.contains("kid");
  size_t tried = 0;
  constexpr size_t kMostTried = 4;  // keys to try for a token without "kid"
  for (const JsonWebKey& key : keys) {
    if (algorithm != (key.algorithm == JwtAlgorithm::rs256 ? "RS256" : "ES256")) continue;
    if (has_id && key.id != id) continue;
    if (tried++ == kMostTried) return false;
    if (key.verifies(text, signature)) return true;
  }
  return false;
}

Result<JwtVerifier::State::Valid> JwtVerifier::State::check(std::string_view token,
                                                            uint64_t now) const {
  constexpr double kClockDifference = 60;  // seconds, between the provider and this machine
  const size_t payload_at = token.find('.') + 1;
  const size_t signature_at = token.find('.', payload_at) + 1;
  const Json header = object_in(token.substr(0, payload_at - 1));
  const Json claims = object_in(token.substr(payload_at, signature_at - 1 - payload_at));
  const auto signature = decode_base64url(token.substr(signature_at));
  if (header.is_null() || claims.is_null() || !signature) {
    return refused("token: expected three parts in base64url, two of them objects of JSON");
  }
  // "crit" names extensions that the receiver must support; this one supports none (RFC 7515,
  // 4.1.11).
  if (header.contains("crit")) return refused("token: expected no critical extension");
  const std::optional<double> until = time_of(claims, "exp");
  if (!until || !(static_cast<double>(now) < *until)) return refused("token: it has expired");
  const double from = time_of(claims, "nbf").value_or(0) - kClockDifference;
  if (!(static_cast<double>(now) >= from)) return refused("token: it is not valid yet");
  if (!options.issuer.empty() && text_of(claims, "iss") != options.issuer) {
    return refused("token: it is of another issuer");
  }
  if (!has_audience(claims, options.audience)) return refused("token: it is for another audience");
  Valid valid{
      {text_of(claims, options.user_claim), groups_of(claims, options.groups_claim)}, from, *until};
  if (!is_name(valid.identity.user)) return refused("token: it names no user");
  if (!is_signed(header, token.substr(0, signature_at - 1), *signature)) {
    return refused("token: its signature is not of a key of the set");
  }
  return valid;
}

Result<Identity> JwtVerifier::verify(std::string_view token, uint64_t now) const {
  if (!is_jwt(token)) return refused("token: expected three parts, at most 8 KiB");
  std::string key(token);
  {
    const std::lock_guard lock(state_->mutex);
    const auto known = state_->known.find(key);
    if (known != state_->known.end()) {
      const auto time = static_cast<double>(now);
      if (time >= known->second.from && time < known->second.until) return known->second.identity;
      state_->known.erase(known);
    }
  }
  Result<State::Valid> valid = state_->check(token, now);
  if (!valid) return tl::unexpected(valid.error());
  // At most 8 MiB. Any token may be dropped, since it can be verified again.
  constexpr size_t kMostKnown = 1024;
  const std::lock_guard lock(state_->mutex);
  if (state_->known.size() >= kMostKnown) state_->known.erase(state_->known.begin());
  Identity identity = valid->identity;
  state_->known.insert_or_assign(std::move(key), std::move(*valid));
  return identity;
}

}  // namespace isosplat::server
