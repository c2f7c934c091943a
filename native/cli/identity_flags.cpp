#include "native/cli/identity_flags.h"

namespace isosplat::cli {

void IdentityFlags::add_to(CLI::App& command) {
  CLI::Option* keys = command
                          .add_option("--jwt-keys", jwt_keys_,
                                      "Keys of an identity provider, whose tokens (JWT) grant "
                                      "access: a JSON Web Key Set in a file or at https://…")
                          ->type_name("FILE|URL");
  CLI::Option* audience =
      command
          .add_option("--jwt-audience", jwt_.audience, "Audience (aud) that the tokens must have")
          ->needs(keys);
  keys->needs(audience);
  command
      .add_option("--jwt-issuer", jwt_.issuer,
                  "Issuer (iss) that the tokens must have (default: any)")
      ->needs(keys);
  command.add_option("--jwt-user", jwt_.user_claim, "Claim that holds the user's name")
      ->needs(keys)
      ->type_name("CLAIM")
      ->capture_default_str();
  command.add_option("--jwt-groups", jwt_.groups_claim, "Claim that holds the user's groups")
      ->needs(keys)
      ->type_name("CLAIM")
      ->capture_default_str();
}

void IdentityFlags::apply(server::ServerOptions& options) const {
  options.jwt_keys = jwt_keys_;
  options.jwt = jwt_;
}

}  // namespace isosplat::cli
