#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/builder/block_encoder.h"
#include "shared/core/grid/volume_header.h"

// The content of the messages between the ranks of a build. All ranks run the same version of the
// program on machines of one byte order.
namespace isosplat {

/// For the memory plan: messages take at most as much memory as this number of encoders.
inline constexpr unsigned kMessageEncoders = 2;

/// What rank 0 learns of a rank that is ready.
struct RankReady {
  uint64_t volume = 0;   ///< volume_digest()
  uint32_t threads = 0;  ///< that encode
  uint32_t reserved = 0;
};

/// A share of the slices to scan: [first, end).
struct ScanOrder {
  int32_t first = 0, end = 0;
};

/// Asks the rank that reads the layer z of level 0 to send the task of a block to a rank.
struct TaskOrder {
  double storage_weight = 0, overhead_cells = 0, max_bytes = 0;
  uint32_t max_candidates = 0;
  uint32_t number = 0;  ///< of the block in its layer
  int32_t z = 0;
  int32_t encoder = 0;  ///< the rank that encodes the block
};

TaskOrder order_of(const BlockTask& task, int encoder);
/// blocks_x: how many blocks the level has along x.
BlockTask task_of(const TaskOrder& order, int32_t blocks_x);

/// Identifies size and type of a volume, to detect ranks that have opened another one.
uint64_t volume_digest(const VolumeHeader& header);

/// The rank that reads a layer of level 0. Rank 0 has the second layer, not the first one: it reads
/// the sample of the volume before it reads layers.
inline int layer_reader_of(int32_t z, int ranks) {
  return (z + 1) % ranks;
}

template <class T>
std::vector<std::byte> packed(const T& content) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto bytes = std::as_bytes(std::span(&content, 1));
  return {bytes.begin(), bytes.end()};
}

/// False if the message has another size.
template <class T>
bool unpack(std::span<const std::byte> message, T& content) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (message.size() != sizeof content) return false;
  std::memcpy(&content, message.data(), sizeof content);
  return true;
}

/// A message of two parts.
std::vector<std::byte> packed_parts(std::span<const std::byte> first,
                                    std::span<const std::byte> second);
/// False if the message is not one of packed_parts.
bool unpack_parts(std::span<const std::byte> message, std::span<const std::byte>& first,
                  std::span<const std::byte>& second);

/// The numbers of a part of a message.
template <class T>
std::vector<T> numbers_of(std::span<const std::byte> part) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<T> numbers(part.size() / sizeof(T));
  if (!numbers.empty()) std::memcpy(numbers.data(), part.data(), numbers.size() * sizeof(T));
  return numbers;
}

std::vector<std::byte> failure_message(const Error& error);
Error failure_of(std::span<const std::byte> message);

/// The error for a message that is not of this version.
tl::unexpected<Error> malformed_message();

}  // namespace isosplat
