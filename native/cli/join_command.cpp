#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/store_building.h"
#include "native/cli/terminal.h"

namespace isosplat::cli {
namespace {

struct JoinCall : StoreFlags {
  std::string volume;
  bool removes_parts = false;
};

int run(const JoinCall& flags) {
  if (flags.quiet) set_quiet();
  auto call = flags.store_call();
  if (!call) return report(call.error());
  call->volume = flags.volume;
  call->joins = true;
  call->removes_parts = flags.removes_parts;
  return build_one_store(std::move(*call));
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
  command->add_flag("--remove-parts", call->removes_parts,
                    "Remove the parts when the store is complete");
  call->add_to(*command);
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
