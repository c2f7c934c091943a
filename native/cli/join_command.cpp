#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/store_building.h"
#include "native/cli/terminal.h"

namespace isosplat::cli {
namespace {

struct JoinCall {
  std::string volume, store;
  VolumeFlags volume_flags;
  BuildFlags build_flags;
  bool quiet = false, force = false, no_thumbnail = false, removes_parts = false;
};

int run(const JoinCall& call) {
  if (call.quiet) set_quiet();
  auto import_options = call.volume_flags.options();
  if (!import_options) return report(import_options.error());
  auto build_options = call.build_flags.options();
  if (!build_options) return report(build_options.error());
  import_options->memory_bytes = build_options->memory_bytes;
  StoreCall store;
  store.volume = call.volume;
  store.store = call.store;
  store.import = *import_options;
  store.build = *build_options;
  store.volume_key = call.volume_flags.key();
  store.joins = true;
  store.removes_parts = call.removes_parts;
  store.quiet = call.quiet;
  store.force = call.force;
  store.no_thumbnail = call.no_thumbnail;
  return build_one_store(std::move(store));
}

}  // namespace

void add_join_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("join", "Join the parts of isosplat build --part to a store");
  auto call = std::make_shared<JoinCall>();
  command->add_option("volume", call->volume, "The volume of which the parts were built")
      ->required();
  command->add_option("-o,--output", call->store,
                      "The store to write (default: NAME.isosplat in the folder of the volume "
                      "NAME). Its parts are beside it: STORE.part-1-of-N to STORE.part-N-of-N");
  command->add_flag("-q,--quiet", call->quiet, "Print nothing on success");
  command->add_flag("--force", call->force,
                    "Replace the output file even if it is a store of another volume, or no store");
  command->add_flag("--no-thumbnail", call->no_thumbnail,
                    "Do not draw the thumbnail, STORE.png beside the store");
  command->add_flag("--remove-parts", call->removes_parts,
                    "Remove the parts when the store is complete");
  call->build_flags.add_to(*command);
  call->volume_flags.add_to(*command);
  command->footer(examples(
      "  isosplat build ct.nrrd -o ct.isosplat --part 1/3     on any machines, in any order\n"
      "  isosplat build ct.nrrd -o ct.isosplat --part 2/3\n"
      "  isosplat build ct.nrrd -o ct.isosplat --part 3/3\n"
      "  isosplat join ct.nrrd -o ct.isosplat --remove-parts\n"
      "The store is byte for byte that of one build. Give join the same options as the parts. It\n"
      "encodes the coarser levels. It reads voxels only where the size limit of the store (see\n"
      "isosplat build --help, --fetch-weight) changes blocks, which it encodes again."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
