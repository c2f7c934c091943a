#include "server/access_rules.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <algorithm>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "server/target.h"
#include "server/volume_names.h"

namespace isosplat {
namespace {

constexpr std::string_view kAnyone = "anyone", kUser = "user:", kGroup = "group:";

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

std::optional<std::array<unsigned char, 32>> sha256(std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned int bytes = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &bytes, EVP_sha256(), nullptr) != 1 ||
      bytes != digest.size()) {
    return std::nullopt;
  }
  return digest;
}

/// The characters of bearer tokens (RFC 6750, 2.1), all of which a cookie may hold.
bool is_token(std::string_view text) {
  return text.size() >= AccessRules::kMinTokenLength && std::ranges::all_of(text, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  std::string_view("-._~+/=").find(c) != std::string_view::npos;
         });
}

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words.back().size());
  }
}

/// Whether `folder` is `outer` or below it.
bool is_within(const std::filesystem::path& folder, const std::filesystem::path& outer) {
  const auto [end, ignored] =
      std::mismatch(outer.begin(), outer.end(), folder.begin(), folder.end());
  return end == outer.end();
}

/// Whether a pattern of a rule admits the volume of this name.
bool matches(std::string pattern, std::string name) {
  if (pattern == "*") return true;
  int flags = FNM_NOESCAPE | FNM_PATHNAME;
  // "ct~*": what is behind the first folder or store that "*" matches is admitted as well.
  if (pattern.ends_with("~*")) flags |= FNM_LEADING_DIR;
  std::ranges::replace(pattern, kFolderSeparator, '/');
  std::ranges::replace(name, kFolderSeparator, '/');
  return ::fnmatch(pattern.c_str(), name.c_str(), flags) == 0;
}

}  // namespace

bool AccessRules::Patterns::admit(const std::string& name,
                                  const std::filesystem::path& folder) const {
  return std::ranges::any_of(names,
                             [&](const std::string& pattern) { return matches(pattern, name); }) ||
         std::ranges::any_of(
             folders, [&](const std::filesystem::path& outer) { return is_within(folder, outer); });
}

Result<void> AccessRules::add_lines(std::string_view text) {
  has_lines_ = true;
  for (size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    const bool is_for_anyone = words.front() == kAnyone;
    const bool is_group = words.front().starts_with(kGroup);
    const std::string_view who = is_group ? words.front().substr(kGroup.size())
                                 : words.front().starts_with(kUser)
                                     ? words.front().substr(kUser.size())
                                     : std::string_view();
    if (!is_for_anyone && who.empty() && !is_token(words.front())) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected \"anyone\", user:NAME, group:NAME, or a token of "
                              "at least {} letters, digits and -._~+/=",
                              number, kMinTokenLength));
    }
    if (words.size() < 2) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected one or more names of volumes (\"*\": all) or "
                              "folders behind the token",
                              number));
    }
    Patterns patterns;
    for (const std::string_view word : std::span(words).subspan(1)) {
      if (word.find('/') == std::string_view::npos) {
        patterns.names.emplace_back(word);
        continue;
      }
      std::error_code error;
      auto folder = std::filesystem::weakly_canonical(word, error);
      if (error) {
        return fail(Status::invalid_argument,
                    fmt::format("line {}: folder {}: {}", number, word, error.message()));
      }
      // "a/b/" has an empty last element.
      patterns.folders.push_back(folder.has_filename() ? folder : folder.parent_path());
    }
    if (is_for_anyone) {
      std::ranges::move(patterns.names, std::back_inserter(anyone_.names));
      std::ranges::move(patterns.folders, std::back_inserter(anyone_.folders));
      continue;
    }
    if (!who.empty()) {
      identity_rules_.push_back({is_group, std::string(who), std::move(patterns)});
      continue;
    }
    const auto digest = sha256(words.front());
    if (!digest) return fail(Status::io_error, "tokens: SHA-256 is not available");
    rules_.push_back({*digest, std::move(patterns)});
  }
  return {};
}

Result<void> AccessRules::add_token(std::string_view token) {
  if (!is_token(token)) {
    return fail(
        Status::invalid_argument,
        fmt::format("token: expected at least {} letters, digits and -._~+/=", kMinTokenLength));
  }
  const auto digest = sha256(token);
  if (!digest) return fail(Status::io_error, "tokens: SHA-256 is not available");
  rules_.push_back({*digest, {.names = {"*"}, .folders = {}}});
  return {};
}

Result<void> AccessRules::set_link_key(std::string_view key) {
  while (key.ends_with('\n') || key.ends_with('\r')) key.remove_suffix(1);
  if (key.size() < kMinKeyLength) {
    return fail(Status::invalid_argument,
                fmt::format("key of links: expected at least {} bytes, found {}: make one with "
                            "openssl rand -hex 32",
                            kMinKeyLength, key.size()));
  }
  link_key_ = key;
  return {};
}

Result<void> AccessRules::add_revoked_links(std::string_view text) {
  for (size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    const std::string_view id = words.front().substr(0, kLinkIdLength);
    const bool is_id = id.size() == kLinkIdLength && std::ranges::all_of(id, [](char c) {
                         return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
                       });
    if (!is_id) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected the signature of a link (its sig=…), or its first "
                              "{} digits",
                              number, kLinkIdLength));
    }
    revoked_links_.emplace(id);
  }
  return {};
}

void AccessRules::admit_identity(const Identity& identity, Grant& grant) const {
  if (identity.user.empty()) return;
  grant.has_identity_ = true;
  const auto matches_name = [](const std::string& pattern, const std::string& name) {
    return ::fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0;
  };
  for (const IdentityRule& rule : identity_rules_) {
    const bool is_meant = rule.is_group
                              ? std::ranges::any_of(identity.groups,
                                                    [&](const std::string& group) {
                                                      return matches_name(rule.pattern, group);
                                                    })
                              : matches_name(rule.pattern, identity.user);
    if (is_meant) grant.patterns_.push_back(&rule.patterns);
  }
}

Grant AccessRules::grant(std::shared_ptr<const AccessRules> rules, const Credentials& credentials,
                         uint64_t now) {
  Grant grant;
  if (!rules || rules->is_open()) return grant;
  rules->admit_identity(credentials.identity, grant);
  // Checking a signature takes about as long as a request.
  constexpr size_t kMaxJwts = 2;
  size_t jwts = 0;
  for (const std::string_view token : credentials.tokens) {
    if (rules->jwt_verifier_ && JwtVerifier::is_jwt(token) && jwts++ < kMaxJwts) {
      if (const Result<Identity> identity = rules->jwt_verifier_->verify(token, now)) {
        rules->admit_identity(*identity, grant);
      }
    }
    const auto digest = sha256(token);
    if (!digest) continue;
    for (const Rule& rule : rules->rules_) {
      if (CRYPTO_memcmp(rule.token.data(), digest->data(), digest->size()) == 0) {
        grant.patterns_.push_back(&rule.patterns);
      }
    }
  }
  for (const Credentials::Link& link : credentials.links) {
    const std::optional<uint32_t> expires = parse_index(link.expires);
    if (rules->link_key_.empty() || !expires || *expires <= now) continue;
    const std::string expected = sign_link(rules->link_key_, link.volume, link.expires);
    if (!expected.empty() && expected.size() == link.signature.size() &&
        CRYPTO_memcmp(expected.data(), link.signature.data(), expected.size()) == 0 &&
        !rules->revoked_links_.contains(link.signature.substr(0, kLinkIdLength))) {
      grant.linked_.emplace_back(link.volume);
    }
  }
  grant.is_known_ = !grant.patterns_.empty() || !grant.linked_.empty() || grant.has_identity_;
  grant.rules_ = std::move(rules);
  return grant;
}

bool Grant::is_public(const std::string& name, const std::filesystem::path& folder) const {
  return !rules_ || rules_->anyone_.admit(name, folder);
}

bool Grant::may_read(const std::string& name, const std::filesystem::path& folder) const {
  return is_public(name, folder) || std::ranges::find(linked_, name) != linked_.end() ||
         std::ranges::any_of(patterns_, [&](const AccessRules::Patterns* patterns) {
           return patterns->admit(name, folder);
         });
}

bool Grant::admits_to_all() const {
  return std::ranges::any_of(patterns_, [](const AccessRules::Patterns* patterns) {
    return std::ranges::find(patterns->names, "*") != patterns->names.end();
  });
}

bool Grant::has_public_volumes() const {
  return !rules_ || !rules_->anyone_.names.empty() || !rules_->anyone_.folders.empty();
}

std::string sign_link(std::string_view key, std::string_view volume, std::string_view expires) {
  // The first line says what is signed, should the key ever sign something else.
  const std::string text = fmt::format("isosplat link 1\n{}\n{}", volume, expires);
  std::array<unsigned char, 32> signature{};
  unsigned int bytes = 0;
  if (!HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
            reinterpret_cast<const unsigned char*>(text.data()), text.size(), signature.data(),
            &bytes) ||
      bytes != signature.size()) {
    return {};
  }
  return hexadecimal(signature);
}

Result<std::string> random_token() {
  std::array<unsigned char, 32> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return fail(Status::io_error, "no random numbers for a token: is /dev/urandom there?");
  }
  return hexadecimal(bytes);
}

}  // namespace isosplat
