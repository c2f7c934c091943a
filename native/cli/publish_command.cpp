#include <fmt/format.h>

#include <algorithm>

#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/serving.h"
#include "native/cli/site.h"
#include "native/cli/terminal.h"

namespace isosplat::cli {
namespace {

struct PublishCall {
  std::vector<std::string> stores;
  std::string to, web_root;
  bool force = false, prune = false;
};

int run(const PublishCall& call) {
  SiteOptions options;
  options.stores.assign(call.stores.begin(), call.stores.end());
  options.to = call.to;
  options.page = find_page(call.web_root);
  options.force = call.force;
  options.prune = call.prune;
  if (options.page.empty()) {
    return report({Status::io_error,
                   "expected the built page beside the program, found none: build it with npm run "
                   "build, or give its folder with --web-root"});
  }
  for (const std::filesystem::path& store : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(store, error)) {
      return report(
          {Status::io_error, fmt::format("{}: expected a store or a folder of stores, found "
                                         "nothing: check the path, or build a store with isosplat "
                                         "build",
                                         store.string())});
    }
  }
  ProgressLine line("Publishing");
  options.progress = [&](uint64_t done, uint64_t all) {
    line.show(static_cast<double>(done) / static_cast<double>(std::max<uint64_t>(all, 1)),
              "copying stores");
  };
  const auto site = publish_site(options);
  line.clear();
  if (!site) return report(site.error());
  for (const SiteVolume& volume : site->volumes) {
    fmt::print("{}: {}{}\n", volume.name, volume.file, volume.is_new ? "" : " (unchanged)");
  }
  for (const std::filesystem::path& path : site->pruned) {
    fmt::print("removed {}\n", path.string());
  }
  fmt::print("{}: a site of {} volume{}: copy it to any web host that supports range requests\n",
             call.to, site->volumes.size(), site->volumes.size() == 1 ? "" : "s");
  return kSuccess;
}

}  // namespace

void add_publish_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("publish", "Write a static web site: the page, a catalog, and stores");
  auto call = std::make_shared<PublishCall>();
  command->add_option("stores", call->stores, "Store files, and folders with *.isosplat files")
      ->required();
  command->add_option("--to", call->to, "Folder of the site, which is created if it does not exist")
      ->required();
  command->add_option("--web-root", call->web_root,
                      "Folder with the page (default: the page built with this program)");
  command->add_flag("--prune", call->prune, "Remove stores and assets that the site does not use");
  command->add_flag("--force", call->force,
                    "Write into the folder even if it contains other files than a site");
  command->footer(examples(
      "  isosplat publish engine.isosplat head.isosplat --to site\n"
      "  isosplat publish stores/ --to site --prune\n"
      "Any web host that supports range requests can serve the site: nginx, Caddy, or a bucket.\n"
      "The host needs no program of Isosplat. Everyone who can reach the host can read all "
      "volumes.\n"
      "To update a site, publish it again: only new and changed stores are copied. The file name "
      "of\n"
      "a store contains its content id, so caches may keep the file for ever."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
