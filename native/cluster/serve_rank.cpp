#include <cstring>
#include <thread>

#include "native/builder/refusals.h"
#include "native/cluster/messages.h"
#include "native/cluster/ranged_volume.h"
#include "native/cluster/rank_build.h"
#include "native/cluster/rank_pause.h"
#include "native/cluster/rank_worker.h"

namespace isosplat {
namespace {

/// The exit code of `stop`.
int exit_code_of(const Message& stop) {
  int exit_code = 1;
  return unpack(stop.content, exit_code) ? exit_code : 1;
}

/// Handles messages until rank 0 sends `stop`. Returns its exit code.
Result<int> serve(VolumeSource& source, const BuildOptions& options, Transport& transport) {
  auto volume = RangedVolume::create(source, options);
  if (!volume) return tl::unexpected(volume.error());
  RankWorker worker(volume->source(), options, transport);
  transport.send(0, MessageKind::ready,
                 packed(RankReady{volume_digest(source.header()), thread_count(options), 0}));
  for (;;) {
    auto message = transport.receive();
    if (message && message->kind == MessageKind::stop) return exit_code_of(*message);
    if (message && message->kind == MessageKind::finish) {
      transport.send(
          0, MessageKind::statistics,
          packed_parts(worker.statistics().bytes(), std::as_bytes(volume->clamped_slices())));
    } else if (message) {
      if (auto handled = worker.handle(std::move(*message)); !handled) {
        return tl::unexpected(handled.error());
      }
    }
    const auto sent = with_refusals([&] { return worker.send_finished(); });
    if (!sent) return tl::unexpected(sent.error());
    if (!message && !*sent) worker.wait();
  }
}

}  // namespace

int serve_rank(VolumeSource& source, const BuildOptions& options, Transport& transport) {
  const auto served = with_refusals([&] { return serve(source, options, transport); });
  return served ? *served : refuse_rank(served.error(), transport);
}

int refuse_rank(const Error& error, Transport& transport) {
  transport.send(0, MessageKind::failed, failure_message(error));
  for (;;) {
    const auto message = transport.receive();
    if (message && message->kind == MessageKind::stop) return exit_code_of(*message);
    if (!message) std::this_thread::sleep_for(pause_of(transport));
  }
}

}  // namespace isosplat
