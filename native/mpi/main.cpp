#include <fmt/format.h>
#include <isosplat/version.h>
#include <malloc.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <thread>

#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/program.h"
#include "native/cli/store_building.h"
#include "native/cli/terminal.h"
#include "native/cluster/rank_build.h"
#include "native/mpi/mpi_transport.h"
#include "shared/import/open_volume.h"

// isosplat-mpi: builds a store with several processes, which mpirun starts.
namespace isosplat::cli {
namespace {

struct MpiBuildCall : StoreFlags {
  std::string volume;
};

/// The cores that this process may use, if all processes of the machine share its cores evenly.
unsigned cores_of_rank(int ranks_on_machine) {
  unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const unsigned share = std::max(1u, cores / static_cast<unsigned>(ranks_on_machine));
  if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0) return share;
  return std::clamp(static_cast<unsigned>(CPU_COUNT(&allowed)), 1u, share);
}

/// What the ranks other than 0 do. Returns the exit code of rank 0: mpirun waits for the others if
/// their exit codes differ.
int serve(const StoreCall& call, Transport& transport) {
  try {
    const auto opened = import::open_volume(call.volume, call.import);
    if (!opened) return refuse_rank(opened.error(), transport);
    return serve_rank(*opened->source, call.build, transport);
  } catch (const std::exception& error) {
    return refuse_rank({Status::out_of_memory, error.what()}, transport);
  }
}

/// A rank may be reading from a disk that hangs. MPI ends all ranks when rank 0 ends without it.
void end_soon(int exit_code) {
  std::thread([exit_code] {
    std::this_thread::sleep_for(std::chrono::seconds(3));
    std::_Exit(exit_code);
  }).detach();
}

int run(const MpiBuildCall& flags, const MpiSession& session, Transport& transport) {
  const bool is_first = transport.rank() == 0;
  if (flags.quiet || !is_first) set_quiet();
  auto call = flags.store_call();
  if (!call) return is_first ? report(call.error()) : kUsage;  // the same error on all ranks
  call->volume = flags.volume;
  if (call->build.threads == 0) {
    call->build.threads = cores_of_rank(session.ranks_on_machine());
  }
  if (!is_first) return serve(*call, transport);
  call->builder = [&](VolumeSource& source, const std::filesystem::path& target,
                      const BuildOptions& options) {
    if (source.resident_bytes() > 0 && transport.ranks() > 1) {
      note("this format cannot be read in part: each rank reads the whole volume");
    }
    auto built = build_store_file_on_ranks(source, target, options, transport);
    if (built) stop_ranks(transport, kSuccess);
    return built;
  };
  const auto end_all = [&](int exit_code) {
    end_soon(exit_code);
    stop_ranks(transport, exit_code);
  };
  try {
    const int exit_code = build_one_store(std::move(*call));
    if (exit_code != kSuccess) end_all(exit_code);
    return exit_code;
  } catch (...) {
    end_all(kFailure);
    throw;  // run_program prints it
  }
}

/// How a signal ends a rank other than 0: a second later than rank 0, which removes the store's
/// temporary file. mpirun sends SIGTERM to all ranks and SIGKILL a second later, or as soon as one
/// rank has ended, even if others have not had a turn yet.
extern "C" void end_after_rank_0(int signal) {
  ::sleep(1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Keeps the memory of messages, which have up to a few MB, for the next ones. By default, the
/// system would take it back and clear it again for each message.
void keep_memory_of_messages() {
#ifdef __GLIBC__
  ::mallopt(M_MMAP_THRESHOLD, 8 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 32 << 20);
#endif
}

}  // namespace
}  // namespace isosplat::cli

int main(int argc, char** argv) {
  isosplat::cli::keep_memory_of_messages();
  isosplat::MpiSession session(argc, argv);
  isosplat::cli::handle_signals();
  isosplat::MpiTransport transport;
  if (transport.rank() != 0) std::signal(SIGTERM, isosplat::cli::end_after_rank_0);
  CLI::App program("Builds a store from a volume with several processes, which mpirun starts.",
                   "isosplat-mpi");
  program.set_version_flag("--version", "isosplat-mpi " ISOSPLAT_VERSION);
  program.require_subcommand(1);
  CLI::App* command = program.add_subcommand(
      "build", "Build a store from a volume; see isosplat build --help for all that it reads");
  const auto call = std::make_shared<isosplat::cli::MpiBuildCall>();
  command->add_option("volume", call->volume, "The volume, which all processes can read")
      ->required();
  command->add_option("-o,--output", call->store,
                      "The store to write (default: NAME.isosplat in the folder of the volume "
                      "NAME)");
  call->add_to(*command);
  command->footer(isosplat::cli::examples(
      "  mpirun -n 4 isosplat-mpi build huge.nrrd -o huge.isosplat\n"
      "  srun isosplat-mpi build huge.nrrd --memory 4G --threads 8     in a Slurm job\n"
      "--memory and --threads are those of each process. By default, the processes of a machine\n"
      "share its cores. The store is byte for byte that of isosplat build."));
  int exit_code = isosplat::cli::kSuccess;
  command->callback([&] { exit_code = isosplat::cli::run(*call, session, transport); });
  return isosplat::cli::run_program(program, argc, argv, exit_code, transport.rank() != 0);
}
