#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace isosplat {

/// What a message between the ranks of a build contains. "To 0" and "from 0": rank 0 receives or
/// sends it; also rank 0 from and to itself.
enum class MessageKind : int {
  ready = 1,   ///< to 0: RankReady; the rank has opened the volume
  failed,      ///< to 0: failure_message(); the rank waits for stop
  scan,        ///< from 0: ScanOrder
  scanned,     ///< to 0: VoxelScan::bytes()
  quantize,    ///< from 0: VoxelScan::bytes() of all voxels; the rank may read its layers
  begin,       ///< from 0: the distribution of isovalues; tasks may follow
  order,       ///< from 0 to the rank that reads the layer: TaskOrder
  task,        ///< to the rank that encodes the block: write_task()
  encoded,     ///< to 0: encode_task()
  finish,      ///< from 0: all blocks are encoded
  statistics,  ///< to 0: two parts: VolumeStatistics::bytes(), ClampedSource::of_slices()
  stop,        ///< from 0: an int, the exit code; end, whatever the rank is doing
};

struct Message {
  int from = 0;
  MessageKind kind{};
  std::vector<std::byte> content;
};

/// Messages between the processes of a build, which are numbered from 0: "ranks". One thread calls
/// it. Messages from one rank to another arrive in the order in which they were sent.
class Transport {
 public:
  virtual ~Transport() = default;

  virtual int rank() const = 0;
  virtual int ranks() const = 0;

  /// Sends a message, also to this rank itself. Does not wait until it has arrived.
  virtual void send(int to, MessageKind kind, std::vector<std::byte> content) = 0;

  /// The next message; none if there is none now. Messages make progress only in calls.
  virtual std::optional<Message> receive() = 0;

  /// Whether messages are on their way to or from this rank. Then receive() should be called soon.
  virtual bool is_busy() const = 0;
};

}  // namespace isosplat
