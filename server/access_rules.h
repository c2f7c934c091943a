#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/jwt.h"
#include "shared/base/status.h"

namespace isosplat {

/// What a client shows to be admitted. The views refer to the request and its target.
struct Credentials {
  /// A signed link: whoever has it may read one volume until it expires.
  struct Link {
    std::string_view volume;
    std::string_view expires;    ///< seconds since 1970, decimal
    std::string_view signature;  ///< of both, as sign_link() makes it
  };
  std::vector<std::string_view> tokens;
  std::vector<Link> links;
  Identity identity{};  ///< as a trusted proxy says; without a user: nobody
};

class Grant;

/// Who may read which volumes. Without tokens and without a key for links, everyone may read every
/// volume. Thread-safe once it is filled.
class AccessRules {
 public:
  /// Adds the rules of a token file. Each line has a token, the word "anyone", or "user:" or
  /// "group:" and a name of an Identity ("*" and "?": any characters), and one or more
  /// patterns, separated by blanks. A pattern without "/" is compared with the names of volumes, in
  /// which "*" and "?" stand for any characters except "~"; "*" alone admits to all, and one that
  /// ends with "~*" to all below the folder. One with "/" is a folder on the disk, and admits the
  /// stores in it and below it. Empty lines and lines that begin with "#" are ignored. Errors
  /// (invalid_argument) name the line, not the token.
  Result<void> add_lines(std::string_view text);

  /// Adds a token for all volumes. Errors (invalid_argument): fewer than kMinTokenLength
  /// characters, or others than letters, digits and "-._~+/=".
  Result<void> add_token(std::string_view token);

  /// Sets the key of signed links. Errors (invalid_argument): fewer than kMinKeyLength bytes.
  Result<void> set_link_key(std::string_view key);

  /// Sets what checks tokens that are JWTs.
  void set_jwt_verifier(std::shared_ptr<const JwtVerifier> verifier) {
    jwt_verifier_ = std::move(verifier);
  }

  /// Adds links that are no longer valid: each line has a signature, or its first
  /// kLinkIdLength digits. Empty lines, and what follows "#" or a blank, are ignored. Errors
  /// (invalid_argument) name the line.
  Result<void> add_revoked_links(std::string_view text);

  /// From now on, only those are admitted who have a right.
  void close() { has_lines_ = true; }

  /// Whether there is a rule for users or groups.
  bool has_identity_rules() const { return !identity_rules_.empty(); }

  /// Whether everyone may read everything.
  bool is_open() const {
    return rules_.empty() && link_key_.empty() && !has_lines_ && !jwt_verifier_;
  }

  /// What a client with these credentials may read at `now` (seconds since 1970). Tokens and
  /// signatures are compared in constant time. `rules`: null is the same as open.
  static Grant grant(std::shared_ptr<const AccessRules> rules, const Credentials& credentials,
                     uint64_t now);

  static constexpr size_t kMinTokenLength = 16;
  static constexpr size_t kMinKeyLength = 32;
  static constexpr size_t kLinkIdLength = 16;

 private:
  friend class Grant;

  /// Patterns of names and of folders.
  struct Patterns {
    std::vector<std::string> names;
    std::vector<std::filesystem::path> folders;  ///< absolute
    bool admit(const std::string& name, const std::filesystem::path& folder) const;
  };
  using Digest = std::array<unsigned char, 32>;
  struct Rule {
    Digest token;  ///< SHA-256: all have one length, which comparing does not tell
    Patterns patterns;
  };

  struct IdentityRule {
    bool is_group;
    std::string pattern;
    Patterns patterns;
  };
  void admit_identity(const Identity& identity, Grant& grant) const;

  std::vector<Rule> rules_;
  std::vector<IdentityRule> identity_rules_;
  std::shared_ptr<const JwtVerifier> jwt_verifier_;     ///< null: no JWT is valid
  std::set<std::string, std::less<>> revoked_links_{};  ///< first digits of signatures
  Patterns anyone_;
  std::string link_key_;
  bool has_lines_ = false;  ///< a token file was given: even an empty one closes the server
};

/// What one client may read.
class Grant {
 public:
  /// Whether a volume may be read: its name, and the absolute folder of its store.
  bool may_read(const std::string& name, const std::filesystem::path& folder) const;

  /// Whether everyone may read it, so that shared caches may keep it.
  bool is_public(const std::string& name, const std::filesystem::path& folder) const;

  /// Whether a token or link was valid, or none is needed for anything.
  bool is_known() const { return is_known_; }

  /// Whether a token was valid.
  bool has_token() const { return !patterns_.empty(); }

  /// Whether a token for all volumes ("*") was valid.
  bool admits_to_all() const;

  /// Whether some volumes may be read by anyone.
  bool has_public_volumes() const;

 private:
  friend class AccessRules;
  std::shared_ptr<const AccessRules> rules_;  ///< null: open
  std::vector<const AccessRules::Patterns*> patterns_;
  std::vector<std::string> linked_;  ///< names of volumes
  bool is_known_ = true;
  bool has_identity_ = false;
};

/// The signature of a link: HMAC-SHA-256 of the volume's name and the time, as 64 hexadecimal
/// digits.
std::string sign_link(std::string_view key, std::string_view volume, std::string_view expires);

/// A token of 256 random bits, as hexadecimal digits. Errors: io_error (no source of randomness).
Result<std::string> random_token();

}  // namespace isosplat
