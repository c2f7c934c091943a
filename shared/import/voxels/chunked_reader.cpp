#include "shared/import/voxels/chunked_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace isosplat::import {
namespace {

constexpr uint64_t kMaxLayerBytes = uint64_t{512} << 20;
constexpr uint64_t kMaxLayerChunks = uint64_t{1} << 20;

}  // namespace

uint64_t ChunkGrid::chunk_bytes() const {
  uint64_t bytes = element_bytes;
  for (const uint64_t size : chunk) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) return std::numeric_limits<uint64_t>::max();
  }
  return bytes;
}

ChunkedReader::ChunkedReader(std::string name, ChunkGrid grid, const ArrayPart& part)
    : name_(std::move(name)), grid_(std::move(grid)) {
  const size_t rank = grid_.sizes.size();
  std::vector<uint64_t> steps(rank);
  uint64_t step = 1, chunks_step = 1;
  for (size_t i = rank; i-- > 0;) {
    const size_t axis = grid_.order.empty() ? i : grid_.order[i];
    steps[axis] = step;
    step *= grid_.chunk[axis];
  }
  for (size_t i = rank; i-- > 0;) {
    const uint64_t chunk = grid_.chunk[i];
    const auto axis = std::find(part.axes.begin(), part.axes.end(), i);
    if (axis != part.axes.end()) {
      const auto to = static_cast<size_t>(axis - part.axes.begin());
      const uint64_t size = part.sizes[to];
      axes_[to] = {size, grid_.sizes[i], chunk, (size + chunk - 1) / chunk, steps[i], chunks_step};
    } else {
      first_chunk_ += part.at[i] / chunk * chunks_step;
      first_element_ += part.at[i] % chunk * steps[i];
      is_at_edge_ = is_at_edge_ || (part.at[i] / chunk + 1) * chunk > grid_.sizes[i];
    }
    chunks_step *= grid_.chunks_along(i);
  }
  bytes_ = grid_.element_bytes * axes_[0].size * axes_[1].size * axes_[2].size;
  const uint64_t in_layer = axes_[1].chunks * axes_[2].chunks;
  keeps_layer_ = axes_[0].chunk > 1 && in_layer <= kMaxLayerChunks &&
                 in_layer <= kMaxLayerBytes / grid_.chunk_bytes();
  if (keeps_layer_) layer_.resize(static_cast<size_t>(in_layer));
}

Result<void> ChunkedReader::read(uint64_t offset, std::span<std::byte> out) {
  if (offset > bytes_ || out.size() > bytes_ - offset) {
    return fail(Status::truncated,
                fmt::format("{}: expected bytes of the array, found its end", name_));
  }
  if (out.empty()) return {};
  const uint64_t row = axes_[2].size * grid_.element_bytes, slice = axes_[1].size * row;
  const uint64_t last = offset + out.size() - 1;
  const uint64_t first_z = offset / slice, last_z = last / slice;
  // Reads only some rows of a slice.
  const bool is_part = first_z == last_z;
  const uint64_t first_y = is_part ? offset % slice / row : 0;
  const uint64_t last_y = is_part ? last % slice / row : axes_[1].size - 1;
  for (uint64_t cz = first_z / axes_[0].chunk; cz <= last_z / axes_[0].chunk; ++cz) {
    for (uint64_t cy = first_y / axes_[1].chunk; cy <= last_y / axes_[1].chunk; ++cy) {
      for (uint64_t cx = 0; cx < axes_[2].chunks; ++cx) {
        const auto elements = chunk_at(cz, cy, cx);
        if (!elements) return tl::unexpected(elements.error());
        copy(*elements, {cz, cy, cx}, {first_z, last_z, first_y, last_y}, offset, out);
      }
    }
  }
  return {};
}

Result<uint64_t> ChunkedReader::count_after(uint64_t offset, uint64_t max_count) {
  return std::min(max_count, bytes_ - std::min(offset, bytes_));
}

uint64_t ChunkedReader::resident_bytes() const {
  const uint64_t layer = layer_.size() * (grid_.chunk_bytes() + sizeof(layer_[0]));
  // Memory for a chunk as stored, and before and after a filter.
  return layer + 3 * grid_.chunk_bytes();
}

std::vector<uint64_t> ChunkedReader::numbers() const {
  std::vector<uint64_t> numbers;
  for (uint64_t cz = 0; cz < axes_[0].chunks; ++cz) {
    for (uint64_t cy = 0; cy < axes_[1].chunks; ++cy) {
      for (uint64_t cx = 0; cx < axes_[2].chunks; ++cx) numbers.push_back(number_of(cz, cy, cx));
    }
  }
  return numbers;
}

uint64_t ChunkedReader::number_of(uint64_t cz, uint64_t cy, uint64_t cx) const {
  return first_chunk_ + cz * axes_[0].chunks_step + cy * axes_[1].chunks_step +
         cx * axes_[2].chunks_step;
}

/// The elements of a chunk; empty if it does not exist. Valid until the next call.
Result<std::span<const std::byte>> ChunkedReader::chunk_at(uint64_t cz, uint64_t cy, uint64_t cx) {
  if (keeps_layer_ && cz != layer_z_) {
    for (Kept& chunk : layer_) chunk = {};
    layer_z_ = cz;
  }
  Kept& kept = keeps_layer_ ? layer_[static_cast<size_t>(cy * axes_[2].chunks + cx)] : single_;
  if (keeps_layer_ && kept.is_read) return std::span<const std::byte>(kept.elements);
  auto decoded = decode(number_of(cz, cy, cx), is_at_edge(cz, cy, cx));
  if (!decoded) return tl::unexpected(decoded.error());
  kept = {true, std::move(*decoded)};
  return std::span<const std::byte>(kept.elements);
}

/// Whether a chunk reaches beyond the end of an axis.
bool ChunkedReader::is_at_edge(uint64_t cz, uint64_t cy, uint64_t cx) const {
  const auto reaches = [](const Axis& axis, uint64_t i) {
    return (i + 1) * axis.chunk > axis.whole;
  };
  return is_at_edge_ || reaches(axes_[0], cz) || reaches(axes_[1], cy) || reaches(axes_[2], cx);
}

/// Copies the bytes from `offset` on that a chunk contains.
void ChunkedReader::copy(std::span<const std::byte> elements, const std::array<uint64_t, 3>& at,
                         const Range& range, uint64_t offset, std::span<std::byte> out) const {
  const auto [z, y, x] = axes_;
  const uint64_t bytes = grid_.element_bytes, end = offset + out.size();
  const uint64_t begin_z = at[0] * z.chunk, begin_y = at[1] * y.chunk, begin_x = at[2] * x.chunk;
  const uint64_t end_z = std::min({begin_z + z.chunk, z.size, range.last_z + 1});
  const uint64_t end_y = std::min({begin_y + y.chunk, y.size, range.last_y + 1});
  const uint64_t end_x = std::min(begin_x + x.chunk, x.size);
  for (uint64_t iz = std::max(begin_z, range.first_z); iz < end_z; ++iz) {
    for (uint64_t iy = std::max(begin_y, range.first_y); iy < end_y; ++iy) {
      const uint64_t to = ((iz * y.size + iy) * x.size + begin_x) * bytes;
      const uint64_t from = first_element_ + (iz - begin_z) * z.step + (iy - begin_y) * y.step;
      const uint64_t row_end = to + (end_x - begin_x) * bytes;
      if (row_end <= offset || to >= end) continue;
      if (x.step == 1 && !elements.empty()) {
        const uint64_t first = std::max(to, offset), last = std::min(row_end, end);
        std::memcpy(out.data() + (first - offset), elements.data() + from * bytes + (first - to),
                    static_cast<size_t>(last - first));
        continue;
      }
      for (uint64_t i = 0; i < end_x - begin_x; ++i) {
        const auto element = element_at(elements, from + i * x.step);
        for (size_t k = 0; k < element.size(); ++k) {
          const uint64_t place = to + i * bytes + k;
          if (place < offset || place >= end) continue;
          out[static_cast<size_t>(place - offset)] = element[k];
        }
      }
    }
  }
}

std::span<const std::byte> ChunkedReader::element_at(std::span<const std::byte> elements,
                                                     uint64_t i) const {
  static constexpr std::array<std::byte, 16> kZero{};
  const auto bytes = static_cast<size_t>(grid_.element_bytes);
  if (!elements.empty()) return elements.subspan(static_cast<size_t>(i) * bytes, bytes);
  return grid_.fill.empty() ? std::span(kZero).first(bytes) : std::span(grid_.fill);
}

}  // namespace isosplat::import
