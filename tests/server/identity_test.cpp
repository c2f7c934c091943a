// Who a client is: tokens of an identity provider (JWT), fields of a trusted proxy, and links that
// are revoked one by one.

#include <gtest/gtest.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rsa.h>

#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

#include "server/access/access_rules.h"
#include "server/access/jwt.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;
using Key = std::shared_ptr<EVP_PKEY>;

std::string base64url(std::string_view bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                   reinterpret_cast<const unsigned char*>(bytes.data()),
                                   static_cast<int>(bytes.size()));
  text.resize(static_cast<size_t>(size));
  while (text.ends_with('=')) text.pop_back();
  for (char& c : text) c = c == '+' ? '-' : c == '/' ? '_' : c;
  return text;
}

std::string number_of(const Key& key, const char* parameter, int bytes = 0) {
  BIGNUM* number = nullptr;
  EXPECT_EQ(EVP_PKEY_get_bn_param(key.get(), parameter, &number), 1);
  std::string text(static_cast<size_t>(bytes > 0 ? bytes : BN_num_bytes(number)), '\0');
  BN_bn2binpad(number, reinterpret_cast<unsigned char*>(text.data()),
               static_cast<int>(text.size()));
  BN_free(number);
  return base64url(text);
}

const Key& rsa() {
  static const Key key(EVP_RSA_gen(2048), EVP_PKEY_free);
  return key;
}

const Key& p256() {
  static const Key key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  return key;
}

/// An RSA key "r", and a key of P-256 "e", with some that cannot be used.
Json key_set() {
  return {{"keys",
           {{{"kty", "oct"}, {"kid", "s"}, {"k", base64url("0123456789abcdef0123456789abcdef")}},
            {{"kty", "RSA"},
             {"kid", "r"},
             {"alg", "RS256"},
             {"use", "sig"},
             {"n", number_of(rsa(), OSSL_PKEY_PARAM_RSA_N)},
             {"e", number_of(rsa(), OSSL_PKEY_PARAM_RSA_E)}},
            {{"kty", "EC"},
             {"kid", "e"},
             {"crv", "P-256"},
             {"x", number_of(p256(), OSSL_PKEY_PARAM_EC_PUB_X, 32)},
             {"y", number_of(p256(), OSSL_PKEY_PARAM_EC_PUB_Y, 32)}},
            {{"kty", "OKP"}, {"crv", "Ed25519"}, {"x", "AA"}}}}};
}

std::string signature_of(const Key& key, const std::string& text, const EVP_MD* digest) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        EVP_MD_CTX_free);
  EXPECT_EQ(EVP_DigestSignInit(context.get(), nullptr, digest, nullptr, key.get()), 1);
  std::string signature(1024, '\0');
  size_t size = signature.size();
  EXPECT_EQ(EVP_DigestSign(context.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                           reinterpret_cast<const unsigned char*>(text.data()), text.size()),
            1);
  signature.resize(size);
  if (EVP_PKEY_get_base_id(key.get()) != EVP_PKEY_EC) return signature;
  const auto* der = reinterpret_cast<const unsigned char*>(signature.data());
  ECDSA_SIG* const pair = d2i_ECDSA_SIG(nullptr, &der, static_cast<long>(size));
  std::string raw(64, '\0');
  BN_bn2binpad(ECDSA_SIG_get0_r(pair), reinterpret_cast<unsigned char*>(raw.data()), 32);
  BN_bn2binpad(ECDSA_SIG_get0_s(pair), reinterpret_cast<unsigned char*>(raw.data()) + 32, 32);
  ECDSA_SIG_free(pair);
  return raw;
}

std::string token_of(const Json& header, const Json& claims, const Key& key) {
  const std::string text = base64url(header.dump()) + "." + base64url(claims.dump());
  return text + "." + base64url(signature_of(key, text, EVP_sha256()));
}

constexpr uint64_t kNow = 1'800'000'000;

Json claims(uint64_t now = kNow) {
  return {{"iss", "https://id.example"},
          {"aud", "isosplat"},
          {"sub", "alice"},
          {"exp", now + 600},
          {"nbf", now - 10},
          {"groups", {"staff", "radiology"}}};
}

const Json kRs256 = {{"alg", "RS256"}, {"kid", "r"}, {"typ", "JWT"}};
const Json kEs256 = {{"alg", "ES256"}, {"kid", "e"}};

std::shared_ptr<const JwtVerifier> verifier() {
  auto created = JwtVerifier::create(key_set().dump(),
                                     {.issuer = "https://id.example", .audience = "isosplat"});
  EXPECT_TRUE(created) << created.error().message;
  return *created;
}

TEST(Jwt, BothAlgorithmsNameTheUser) {
  const auto checks = verifier();
  for (const auto& [header, key] : {std::pair(kRs256, rsa()), std::pair(kEs256, p256())}) {
    const std::string token = token_of(header, claims(), key);
    for (int turn = 0; turn < 2; ++turn) {  // the second one is remembered
      const Result<Identity> identity = checks->verify(token, kNow);
      ASSERT_TRUE(identity) << identity.error().message;
      EXPECT_EQ(identity->user, "alice");
      EXPECT_EQ(identity->groups, (std::vector<std::string>{"staff", "radiology"}));
    }
    EXPECT_FALSE(checks->verify(token, kNow + 600)) << "a remembered token expires";
    EXPECT_FALSE(checks->verify(token, kNow - 3600));
  }
  Json other = claims();
  other["aud"] = {"another", "isosplat"};
  other["groups"] = "staff";
  other.erase("nbf");
  const auto identity = checks->verify(token_of({{"alg", "ES256"}}, other, p256()), kNow);
  ASSERT_TRUE(identity) << "without kid, all keys of the algorithm are tried";
  EXPECT_EQ(identity->groups, std::vector<std::string>{"staff"});
}

TEST(Jwt, ForgedAndMalformedTokensAreRefused) {
  const auto checks = verifier();
  const auto refuses = [&](const std::string& token, const char* what) {
    EXPECT_FALSE(checks->verify(token, kNow)) << what;
  };
  const std::string good = token_of(kRs256, claims(), rsa());
  ASSERT_TRUE(checks->verify(good, kNow));
  const std::string text = good.substr(0, good.rfind('.'));
  // No signature.
  for (const char* none : {"none", "None", "NONE", ""}) {
    const std::string unsigned_text =
        base64url(Json({{"alg", none}}).dump()) + "." + base64url(claims().dump());
    refuses(unsigned_text + ".", "none");
    refuses(unsigned_text + "." + good.substr(good.rfind('.') + 1), "none with a signature");
  }
  refuses(text + ".", "the signature removed");
  refuses(text, "two parts");
  refuses(good + ".x", "four parts");
  // HS256 with the public key, or the symmetric key of the set, as the secret.
  for (const std::string& secret : {key_set().dump(), key_set()["keys"][1].dump(),
                                    std::string("0123456789abcdef0123456789abcdef")}) {
    for (const char* id : {"r", "s"}) {
      const std::string mac_text = base64url(Json({{"alg", "HS256"}, {"kid", id}}).dump()) + "." +
                                   base64url(claims().dump());
      std::string mac(32, '\0');
      HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
           reinterpret_cast<const unsigned char*>(mac_text.data()), mac_text.size(),
           reinterpret_cast<unsigned char*>(mac.data()), nullptr);
      refuses(mac_text + "." + base64url(mac), "HS256");
    }
  }
  // Another key, another algorithm, another id.
  const Key stranger(EVP_RSA_gen(2048), EVP_PKEY_free);
  refuses(token_of(kRs256, claims(), stranger), "another key");
  Json with_key = kRs256;
  with_key["jwk"] = {{"kty", "RSA"},
                     {"n", number_of(stranger, OSSL_PKEY_PARAM_RSA_N)},
                     {"e", number_of(stranger, OSSL_PKEY_PARAM_RSA_E)}};
  refuses(token_of(with_key, claims(), stranger), "a key in the header");
  refuses(token_of({{"alg", "RS256"}, {"kid", "e"}}, claims(), rsa()), "the id of another key");
  refuses(token_of({{"alg", "RS256"}, {"kid", "x"}}, claims(), rsa()), "an unknown id");
  refuses(token_of({{"alg", "RS256"}, {"kid", 7}}, claims(), rsa()), "an id that is no text");
  refuses(token_of({{"alg", "ES256"}, {"kid", "r"}}, claims(), rsa()), "another algorithm");
  refuses(token_of({{"alg", "RS512"}, {"kid", "r"}}, claims(), rsa()), "an algorithm not allowed");
  refuses(token_of({{"alg", {"RS256"}}, {"kid", "r"}}, claims(), rsa()), "alg is no text");
  refuses(token_of({{"kid", "r"}}, claims(), rsa()), "no algorithm");
  Json critical = kRs256;
  critical["crit"] = {"exp"};
  refuses(token_of(critical, claims(), rsa()), "crit");
  // Claims.
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, Json>>{{"exp", kNow},
                                                           {"exp", kNow - 1},
                                                           {"exp", nullptr},
                                                           {"exp", "2100-01-01"},
                                                           {"exp", "99999999999"},
                                                           {"nbf", kNow + 3600},
                                                           {"nbf", "soon"},
                                                           {"iss", "https://evil.example"},
                                                           {"iss", nullptr},
                                                           {"aud", "another"},
                                                           {"aud", {"another"}},
                                                           {"aud", nullptr},
                                                           {"aud", {{"isosplat", 1}}},
                                                           {"sub", ""},
                                                           {"sub", 7},
                                                           {"sub", "a\nb"},
                                                           {"sub", std::string(300, 'x')}}) {
    Json changed = claims();
    changed[name] = value;
    refuses(token_of(kRs256, changed, rsa()), name);
    if (!value.is_null()) continue;
    changed.erase(name);
    refuses(token_of(kRs256, changed, rsa()), name);
  }
  // Bytes.
  for (size_t at = 0; at < good.size(); at += 7) {
    std::string changed = good;
    changed[at] = changed[at] == 'A' ? 'B' : 'A';
    refuses(changed, "one character changed");
  }
  refuses(good + "=", "padding");
  refuses(text + ".AA" + good.substr(good.rfind('.') + 1), "a longer signature");
  refuses("..", "empty parts");
  refuses(base64url("[]") + "." + base64url("[]") + ".AA", "no objects");
  refuses(base64url(std::string(3000, '[')) + "." + base64url("{}") + ".AA", "nested");
  Json large = claims();
  large["x"] = std::string(JwtVerifier::kMaxBytes, 'x');
  refuses(token_of(kRs256, large, rsa()), "oversized");
}

TEST(Jwt, SignaturesOfP256HaveOneForm) {
  const auto checks = verifier();
  const std::string good = token_of(kEs256, claims(), p256());
  const std::string text = good.substr(0, good.rfind('.'));
  ASSERT_TRUE(checks->verify(good, kNow));
  for (const std::string& signature : {std::string(64, '\0'), std::string(64, '\xff'),
                                       std::string(63, '\1'), std::string(72, '\1')}) {
    EXPECT_FALSE(checks->verify(text + "." + base64url(signature), kNow));
  }
}

TEST(Jwt, EveryKeyOfASetIsChecked) {
  const auto error_of = [](const std::string& keys) {
    const auto created = JwtVerifier::create(keys, {.issuer = "", .audience = "isosplat"});
    EXPECT_FALSE(created) << keys;
    return created ? "" : created.error().message;
  };
  for (const char* text : {"", "[]", "{}", "{\"keys\":{}}", "{\"keys\":[]}", "{\"keys\":[7]}",
                           "{\"keys\":[{\"kty\":\"oct\",\"k\":\"AAAA\"}]}"}) {
    error_of(text);
  }
  Json weak = key_set();
  const Key small(EVP_RSA_gen(1024), EVP_PKEY_free);
  weak["keys"][1]["n"] = number_of(small, OSSL_PKEY_PARAM_RSA_N);
  EXPECT_NE(error_of(weak.dump()).find("key 2: expected an RSA key of 2048"), std::string::npos);
  Json trivial = key_set();
  trivial["keys"][1]["e"] = "AQ";
  error_of(trivial.dump());
  Json off = key_set();
  off["keys"][2]["y"] = off["keys"][2]["x"];
  EXPECT_NE(error_of(off.dump()).find("key 3: expected a point of P-256"), std::string::npos);
  Json many;
  for (int i = 0; i < 65; ++i) many["keys"].push_back(key_set()["keys"][1]);
  error_of(many.dump());
  EXPECT_FALSE(JwtVerifier::create(key_set().dump(), {})) << "no audience";
}

class Identities : public ServerTest {
 protected:
  Identities() {
    write_file(folder.path() / "beta.isosplat", alpha.file);
    options.token_file = secrets.path() / "tokens";
    write_file(options.token_file,
               std::string_view("user:alice alpha\ngroup:radiology beta\nuser:root* *\n"
                                "token-0123456789abcdef *\n"));
  }
  void use_jwt() {
    options.jwt_keys = secrets.path() / "keys.json";
    write_file(options.jwt_keys, key_set().dump());
    options.jwt = {.issuer = "https://id.example", .audience = "isosplat"};
  }

  /// The status of alpha, beta and the list.
  std::vector<int> statuses(const std::string& fields) {
    std::vector<int> result;
    Client client(port());
    for (const char* path : {"/v1/volumes/alpha", "/v1/volumes/beta", "/v1/volumes"}) {
      result.push_back(client.request("GET", path, fields).status);
    }
    return result;
  }

  TemporaryFolder secrets;
};

TEST_F(Identities, TokensOfTheProviderAdmitByUserAndGroup) {
  use_jwt();
  start();
  const auto with = [&](Json changed) {
    return "Authorization: Bearer " + token_of(kRs256, changed, rsa()) + "\r\n";
  };
  const auto now = static_cast<uint64_t>(std::time(nullptr));
  Json alice = claims(now);
  EXPECT_EQ(statuses(with(alice)), (std::vector{200, 200, 200}));
  alice["groups"] = {"staff"};
  EXPECT_EQ(statuses(with(alice)), (std::vector{200, 404, 200}));
  Json bob = alice;
  bob["sub"] = "bob";
  EXPECT_EQ(statuses(with(bob)), (std::vector{404, 404, 200})) << "known, but without rights";
  bob["sub"] = "root-7";
  EXPECT_EQ(statuses(with(bob)), (std::vector{200, 200, 200}));
  alice["exp"] = now - 1;
  EXPECT_EQ(statuses(with(alice)), (std::vector{401, 401, 401}));
  EXPECT_EQ(statuses(""), (std::vector{401, 401, 401}));
  EXPECT_EQ(statuses("Authorization: Bearer token-0123456789abcdef\r\n"),
            (std::vector{200, 200, 200}));
  EXPECT_EQ(statuses("X-Forwarded-User: alice\r\n"), (std::vector{401, 401, 401}));
}

TEST_F(Identities, APageGetsACookieForAToken) {
  use_jwt();
  start();
  const std::string token =
      token_of(kRs256, claims(static_cast<uint64_t>(std::time(nullptr))), rsa());
  const Answer moved = get(port(), "/?token=" + token);
  EXPECT_EQ(moved.status, 303);
  const std::string cookie = moved.header("set-cookie");
  EXPECT_EQ(
      get(port(), "/v1/volumes/alpha", "Cookie: " + cookie.substr(0, cookie.find(';')) + "\r\n")
          .status,
      200);
  EXPECT_EQ(get(port(), "/?token=" + token.substr(0, token.size() - 4)).status, 401);
}

TEST_F(Identities, KeysAreReadAgain) {
  use_jwt();
  start();
  const auto now = static_cast<uint64_t>(std::time(nullptr));
  const std::string old = "Authorization: Bearer " + token_of(kRs256, claims(now), rsa()) + "\r\n";
  EXPECT_EQ(statuses(old)[0], 200);
  Json keys = key_set();
  keys["keys"].erase(1);
  write_file(options.jwt_keys, keys.dump());
  EXPECT_TRUE(server->reload());
  EXPECT_EQ(statuses(old)[0], 401) << "also if it was remembered";
  write_file(options.jwt_keys, std::string_view("{}"));
  EXPECT_FALSE(server->reload());
  EXPECT_EQ(statuses("Authorization: Bearer " + token_of(kEs256, claims(now), p256()) + "\r\n")[0],
            200);
}

TEST_F(Identities, AServerCanFetchTheKeys) {
  // The keys are a file of the page of another server.
  TemporaryFolder page;
  write_file(page.path() / "index.html", std::string_view("<title>I</title>"));
  write_file(page.path() / "keys.json", key_set().dump());
  ServerOptions provider_options;
  provider_options.port = 0;
  provider_options.stores = {folder.path()};
  provider_options.web_root = page.path();
  auto provider = Server::start(provider_options);
  ASSERT_TRUE(provider) << provider.error().message;
  use_jwt();
  options.jwt_keys = (*provider)->url() + "keys.json";
  start();
  const auto now = static_cast<uint64_t>(std::time(nullptr));
  const std::string fields =
      "Authorization: Bearer " + token_of(kEs256, claims(now), p256()) + "\r\n";
  EXPECT_EQ(statuses(fields), (std::vector{200, 200, 200}));
  // If the provider does not respond, the previous keys stay valid.
  provider->reset();
  EXPECT_TRUE(server->reload());
  EXPECT_TRUE(will_log("those from before stay"));
  EXPECT_EQ(statuses(fields), (std::vector{200, 200, 200}));
}

TEST_F(Identities, WithoutKeysTokensOfTheProviderAdmitNobody) {
  use_jwt();
  options.jwt_keys = "http://127.0.0.1:1/keys.json";
  start();
  EXPECT_TRUE(will_log("keys of the identity provider"));
  const auto now = static_cast<uint64_t>(std::time(nullptr));
  EXPECT_EQ(statuses("Authorization: Bearer " + token_of(kEs256, claims(now), p256()) + "\r\n"),
            (std::vector{401, 401, 401}));
}

TEST_F(Identities, FieldsOfATrustedProxyAdmit) {
  options.trusted_proxies = {"127.0.0.1"};
  options.proxy_fields.user = "X-Forwarded-User";
  options.proxy_fields.groups = "X-Forwarded-Groups";
  start();
  EXPECT_EQ(statuses("X-Forwarded-User: alice\r\n"), (std::vector{200, 404, 200}));
  EXPECT_EQ(statuses("X-Forwarded-User: bob\r\nX-Forwarded-Groups: staff , radiology\r\n"),
            (std::vector{404, 200, 200}));
  EXPECT_EQ(statuses("X-Forwarded-Groups: radiology\r\n"), (std::vector{401, 401, 401}));
  // If there are two fields, the client may have sent one of them.
  EXPECT_EQ(statuses("X-Forwarded-User: bob\r\nX-Forwarded-User: alice\r\n"),
            (std::vector{401, 401, 401}));
  EXPECT_EQ(statuses("X_Forwarded_User: alice\r\n"), (std::vector{401, 401, 401}));
}

TEST_F(Identities, FieldsOfOtherClientsDoNotAdmit) {
  options.trusted_proxies = {"127.0.0.2"};
  options.proxy_fields.user = "X-Forwarded-User";
  start();
  EXPECT_EQ(statuses("X-Forwarded-User: alice\r\n"), (std::vector{401, 401, 401}));
}

TEST_F(Identities, OptionsThatAdmitNobodyAreRefused) {
  const auto refusal = [&] {
    const auto started = Server::start(options);
    return started ? "" : started.error().message;
  };
  options.proxy_fields.user = "X-Forwarded-User";
  EXPECT_NE(refusal().find("expected the address of the proxy"), std::string::npos);
  options.trusted_proxies = {"127.0.0.1"};
  options.proxy_fields.user = "X Forwarded";
  EXPECT_NE(refusal().find("expected the name of a field"), std::string::npos);
  options.proxy_fields.user = "X-Forwarded-User";
  write_file(options.token_file, std::string_view("token-0123456789abcdef *\n"));
  EXPECT_NE(refusal().find("nobody would be admitted"), std::string::npos);
  write_file(options.token_file, std::string_view("user: *\n"));
  EXPECT_NE(refusal().find("line 1: expected \"anyone\", user:NAME"), std::string::npos);
}

class RevokedLinks : public ServerTest {
 protected:
  RevokedLinks() {
    options.link_key = key;
    options.revoked_links_file = secrets.path() / "revoked";
    write_file(options.revoked_links_file, std::string_view("# none yet\n"));
  }
  std::string signature(const char* expires) const {
    return sign_link(key, ServedKind::volume, "alpha", expires);
  }
  int status(const char* expires) {
    return get(port(),
               std::string("/v1/volumes/alpha?exp=") + expires + "&sig=" + signature(expires))
        .status;
  }
  const std::string key = "fedcba9876543210fedcba9876543210";
  TemporaryFolder secrets;
};

TEST_F(RevokedLinks, EndOneByOne) {
  start();
  constexpr const char *kFirst = "4000000000", *kSecond = "4000000001", *kThird = "4000000002";
  for (const char* link : {kFirst, kSecond, kThird}) EXPECT_EQ(status(link), 200);
  write_file(options.revoked_links_file,
             "\n" + signature(kFirst).substr(0, 16) + "  # lost\n" + signature(kSecond) + "\n");
  EXPECT_TRUE(server->reload());
  EXPECT_EQ(status(kFirst), 401);
  EXPECT_EQ(status(kSecond), 401);
  EXPECT_EQ(status(kThird), 200);
  // The cookie of a link that was opened before it was revoked.
  EXPECT_EQ(get(port(), "/v1/volumes/alpha",
                "Cookie: isosplat-" + std::to_string(port()) + "-link-alpha=" + kFirst + "." +
                    signature(kFirst) + "\r\n")
                .status,
            401);
  for (const char* wrong : {"0123456789abcde", "0123456789ABCDEF", "head"}) {
    write_file(options.revoked_links_file, std::string_view(wrong));
    const Result<void> reloaded = server->reload();
    ASSERT_FALSE(reloaded);
    EXPECT_NE(reloaded.error().message.find("line 1: expected the signature"), std::string::npos);
  }
  EXPECT_EQ(status(kFirst), 401) << "links that were revoked before stay revoked";
}

}  // namespace
}  // namespace isosplat::server::test
