#include "native/cluster/messages.h"

#include <algorithm>
#include <array>
#include <string>

#include "shared/core/store/checksum.h"

namespace isosplat {

TaskOrder order_of(const BlockTask& task, int encoder) {
  return {task.options.storage_weight,
          task.options.overhead_cells,
          task.max_bytes,
          static_cast<uint32_t>(task.options.max_candidates),
          static_cast<uint32_t>(task.number),
          task.index.z,
          encoder};
}

BlockTask task_of(const TaskOrder& order, int32_t blocks_x) {
  const auto number = static_cast<int32_t>(order.number);
  BlockTask task;
  task.number = order.number;
  task.index = {number % blocks_x, number / blocks_x, order.z};
  task.options.storage_weight = order.storage_weight;
  task.options.overhead_cells = order.overhead_cells;
  task.options.max_candidates = order.max_candidates;
  task.max_bytes = order.max_bytes;
  return task;
}

uint64_t volume_digest(const VolumeHeader& header) {
  const Index3 n = header.grid.voxels;
  const std::array numbers{static_cast<double>(n.x),
                           static_cast<double>(n.y),
                           static_cast<double>(n.z),
                           static_cast<double>(header.type),
                           header.slope,
                           header.intercept};
  return checksum64(std::as_bytes(std::span(numbers)));
}

std::vector<std::byte> packed_parts(std::span<const std::byte> first,
                                    std::span<const std::byte> second) {
  const uint64_t bytes = first.size();
  std::vector<std::byte> message(sizeof bytes + first.size() + second.size());
  std::memcpy(message.data(), &bytes, sizeof bytes);
  const auto content = message.begin() + sizeof bytes;
  std::copy(second.begin(), second.end(), std::copy(first.begin(), first.end(), content));
  return message;
}

bool unpack_parts(std::span<const std::byte> message, std::span<const std::byte>& first,
                  std::span<const std::byte>& second) {
  uint64_t bytes = 0;
  if (message.size() < sizeof bytes) return false;
  std::memcpy(&bytes, message.data(), sizeof bytes);
  const auto content = message.subspan(sizeof bytes);
  if (bytes > content.size()) return false;
  first = content.first(static_cast<size_t>(bytes));
  second = content.subspan(static_cast<size_t>(bytes));
  return true;
}

std::vector<std::byte> failure_message(const Error& error) {
  return packed_parts(packed(static_cast<int32_t>(error.status)),
                      std::as_bytes(std::span(error.message)));
}

Error failure_of(std::span<const std::byte> message) {
  std::span<const std::byte> status, text;
  int32_t number = 0;
  if (!unpack_parts(message, status, text) || !unpack(status, number)) {
    return malformed_message().value();
  }
  return {static_cast<Status>(number),
          std::string(reinterpret_cast<const char*>(text.data()), text.size())};
}

tl::unexpected<Error> malformed_message() {
  return fail(Status::invalid_argument,
              "expected messages of this version of the program, found others: start the same "
              "version on all machines");
}

}  // namespace isosplat
