#include <fmt/format.h>

#include <utility>

#include "native/cli/command.h"
#include "native/cli/config_file.h"
#include "native/cli/identity_flags.h"
#include "native/cli/operation_flags.h"
#include "native/cli/options.h"
#include "native/cli/proxy_flags.h"
#include "native/cli/server_flags.h"
#include "native/cli/serving.h"
#include "native/cli/terminal.h"
#include "server/net/hand_over.h"
#include "server/net/service_manager.h"

namespace isosplat::cli {
namespace {

struct ServeCall {
  std::vector<std::string> stores;
  ServerFlags server_flags;
  OperationFlags operation_flags;
  ProxyFlags proxy_flags;
  IdentityFlags identity_flags;
  bool is_check = false;
};

int run(const ServeCall& call) {
  Result<server::ServerOptions> parsed = call.server_flags.options();
  if (!parsed) return report(parsed.error());
  server::ServerOptions options = std::move(*parsed);
  if (Result<void> applied = call.operation_flags.apply(options); !applied) {
    return report(applied.error());
  }
  if (Result<void> applied = call.proxy_flags.apply(options); !applied) {
    return report(applied.error());
  }
  call.identity_flags.apply(options);
  options.sockets = server::take_passed_sockets();
  if (auto handed = server::take_handed_sockets()) {
    options.sockets = std::move(handed->serving);
    options.redirecting_sockets = std::move(handed->redirecting);
  }
  options.stores.assign(call.stores.begin(), call.stores.end());
  for (const std::filesystem::path& store : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(store, error)) {
      return report({Status::io_error, fmt::format("{}: expected a store, a scene or a folder of "
                                                   "them, found nothing: check the path, or build "
                                                   "a store with isosplat build",
                                                   store.string())});
    }
  }
  if (call.is_check) {
    if (Result<void> valid = server::Server::check(options); !valid) return report(valid.error());
    return kSuccess;
  }
  return serve_until_stopped(std::move(options), "");
}

}  // namespace

void add_serve_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("serve", "Serve stores, scenes and the page over HTTP");
  auto call = std::make_shared<ServeCall>();
  add_config_option(*command);
  command
      ->add_option(
          "stores", call->stores,
          "Stores (*.isosplat), scenes (*.isobundle, scene.json, *.scene.json), and folders "
          "with such files")
      ->required();
  call->server_flags.add_to(*command);
  call->operation_flags.add_to(*command);
  call->proxy_flags.add_to(*command);
  call->identity_flags.add_to(*command);
  command
      ->add_flag("--check", call->is_check,
                 "Only check options, tokens, keys and certificates, without serving")
      ->configurable(false);
  command->footer(examples(
      "  isosplat serve engine.isosplat head.isosplat\n"
      "  isosplat serve stores/ --port 8081\n"
      "  isosplat serve head.isobundle\n"
      "  isosplat serve stores/ --host 0.0.0.0 --cors none\n"
      "  isosplat serve stores/ --host 0.0.0.0 --public\n"
      "  isosplat serve stores/ --token-file tokens.txt\n"
      "  isosplat serve --config server.toml\n"
      "  isosplat serve stores/ --host 0.0.0.0 --cors none --token-file tokens.txt\n"
      "    --tls-cert a.example.pem --tls-key a.example.key\n"
      "Without --host, only programs on this machine can reach the server, and only the server's\n"
      "own page can read the volumes.\n"
      "Each line of the token file is TOKEN [name=NAME] PATTERN…. The access log shows NAME. A\n"
      "pattern is the name of a volume, in which * stands for any characters, or the path of a\n"
      "folder or file with a slash (stores/ct/). scene:NAME means a scene. In place of a token, "
      "the word anyone stands for\n"
      "all visitors, and user:NAME or group:NAME for the users that an identity provider or a\n"
      "proxy reports.\n"
      "The token in the environment variable ISOSPLAT_TOKEN grants access to all volumes.\n"
      "ISOSPLAT_LINK_KEY is the key that verifies links.\n"
      "On SIGHUP, the server reads tokens, keys and certificates again, and reopens the access "
      "log.\n"
      "A file for --config has lines such as: stores = [\"/srv/ct\", \"/srv/mr\"]\n"
      "A folder is served with its subfolders: ct/head.isosplat is the volume ct~head, and\n"
      "ct/head.isobundle the scene ct~head; ct/scene.json is the scene ct~scene. If several\n"
      "folders are served, each name begins with that of its folder: stores~ct~head. The server\n"
      "notices new, replaced and removed files at once."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
