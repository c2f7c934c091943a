#include "shared/import/hdf5/array.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/filters.h"
#include "shared/import/hdf5/type.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kMaxLayerBytes = uint64_t{512} << 20;
constexpr uint64_t kMaxLayerChunks = uint64_t{1} << 20;

/// The elements of a chunk along one axis.
struct Axis {
  uint64_t size = 1;         ///< elements that are read
  uint64_t whole = 1;        ///< elements of the array
  uint64_t chunk = 1;        ///< elements of a chunk
  uint64_t chunks = 1;       ///< number of chunks to read
  uint64_t step = 0;         ///< from an element to the next one in a chunk, in elements
  uint64_t chunks_step = 0;  ///< from a chunk to the next one, in numbers of chunks
};

class Hdf5Array : public ByteReader {
 public:
  Hdf5Array(std::shared_ptr<Hdf5File> file, Hdf5Layout layout, const Hdf5Part& part,
            std::vector<Hdf5Chunk> chunks)
      : file_(std::move(file)), layout_(std::move(layout)), chunks_(std::move(chunks)) {
    uint64_t step = 1, chunks_step = 1;
    for (size_t i = layout_.sizes.size(); i-- > 0;) {
      const uint64_t chunk = layout_.chunk[i];
      const auto axis = std::find(part.axes.begin(), part.axes.end(), i);
      if (axis != part.axes.end()) {
        const auto to = static_cast<size_t>(axis - part.axes.begin());
        const uint64_t size = part.sizes[to];
        axes_[to] = {size, layout_.sizes[i], chunk, (size + chunk - 1) / chunk, step, chunks_step};
      } else {
        first_chunk_ += part.at[i] / chunk * chunks_step;
        first_element_ += part.at[i] % chunk * step;
        is_at_edge_ = is_at_edge_ || (part.at[i] / chunk + 1) * chunk > layout_.sizes[i];
      }
      step *= chunk;
      chunks_step *= layout_.chunks_along(i);
    }
    bytes_ = layout_.element_bytes * axes_[0].size * axes_[1].size * axes_[2].size;
    const uint64_t in_layer = axes_[1].chunks * axes_[2].chunks;
    keeps_layer_ = axes_[0].chunk > 1 && in_layer <= kMaxLayerChunks &&
                   in_layer <= kMaxLayerBytes / layout_.chunk_bytes();
    if (keeps_layer_) layer_.resize(static_cast<size_t>(in_layer));
  }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_ || out.size() > bytes_ - offset) {
      return fail(Status::truncated, fmt::format("{}: expected bytes of the array, found its end",
                                                 file_->path().string()));
    }
    if (out.empty()) return {};
    const uint64_t row = axes_[2].size * layout_.element_bytes, slice = axes_[1].size * row;
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

  // Otherwise, a chunk is decoded once for each of its slices.
  bool is_random_access() const override { return keeps_layer_ || axes_[0].chunk == 1; }
  uint64_t size_limit() const override { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    return std::min(max_count, bytes_ - std::min(offset, bytes_));
  }
  uint64_t available_bytes() override { return bytes_; }
  uint64_t resident_bytes() const override {
    const uint64_t layer = layer_.size() * (layout_.chunk_bytes() + sizeof(layer_[0]));
    // Memory for a chunk as stored, and before and after a filter.
    return layer + 3 * layout_.chunk_bytes() + chunks_.size() * sizeof(Hdf5Chunk);
  }
  std::vector<std::filesystem::path> files() const override { return {file_->path()}; }

 private:
  /// The elements of a chunk; empty if it does not exist. Valid until the next call.
  Result<std::span<const std::byte>> chunk_at(uint64_t cz, uint64_t cy, uint64_t cx) {
    const uint64_t in_layer = cy * axes_[2].chunks + cx;
    const uint64_t number = first_chunk_ + cz * axes_[0].chunks_step + cy * axes_[1].chunks_step +
                            cx * axes_[2].chunks_step;
    const auto found = std::lower_bound(
        chunks_.begin(), chunks_.end(), number,
        [](const Hdf5Chunk& chunk, uint64_t sought) { return chunk.number < sought; });
    if (found == chunks_.end() || found->number != number) return std::span<const std::byte>{};
    if (keeps_layer_ && cz != layer_z_) {
      for (auto& chunk : layer_) std::vector<std::byte>().swap(chunk);
      layer_z_ = cz;
    }
    auto& kept = keeps_layer_ ? layer_[static_cast<size_t>(in_layer)] : single_;
    if (keeps_layer_ && !kept.empty()) return std::span<const std::byte>(kept);
    // Filters enlarge noise by less than this.
    const uint64_t most = layout_.chunk_bytes() + layout_.chunk_bytes() / 8 + 4096;
    if (found->bytes > most || found->bytes > file_->bytes()) {
      return file_->malformed(
          fmt::format("expected a chunk of at most {} bytes, found {}", most, found->bytes));
    }
    std::vector<std::byte> stored(static_cast<size_t>(found->bytes));
    if (auto read = file_->read_data(found->address, stored); !read) {
      return tl::unexpected(read.error());
    }
    uint32_t mask = found->mask;
    if (layout_.has_plain_edges && is_at_edge(cz, cy, cx)) mask = ~uint32_t{0};
    auto decoded = decoder_.decode(*file_, layout_, std::move(stored), mask);
    if (!decoded) return tl::unexpected(decoded.error());
    kept = std::move(*decoded);
    return std::span<const std::byte>(kept);
  }

  /// Whether a chunk reaches beyond the end of an axis.
  bool is_at_edge(uint64_t cz, uint64_t cy, uint64_t cx) const {
    const auto reaches = [](const Axis& axis, uint64_t i) {
      return (i + 1) * axis.chunk > axis.whole;
    };
    return is_at_edge_ || reaches(axes_[0], cz) || reaches(axes_[1], cy) || reaches(axes_[2], cx);
  }

  struct Range {
    uint64_t first_z, last_z, first_y, last_y;
  };

  /// Copies the bytes from `offset` on that a chunk contains.
  void copy(std::span<const std::byte> elements, const std::array<uint64_t, 3>& at,
            const Range& range, uint64_t offset, std::span<std::byte> out) const {
    const auto [z, y, x] = axes_;
    const uint64_t bytes = layout_.element_bytes, end = offset + out.size();
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

  std::span<const std::byte> element_at(std::span<const std::byte> elements, uint64_t i) const {
    static constexpr std::array<std::byte, 16> kZero{};
    const auto bytes = static_cast<size_t>(layout_.element_bytes);
    if (!elements.empty()) return elements.subspan(static_cast<size_t>(i) * bytes, bytes);
    return layout_.fill.empty() ? std::span(kZero).first(bytes) : std::span(layout_.fill);
  }

  std::shared_ptr<Hdf5File> file_;
  Hdf5Layout layout_;
  std::vector<Hdf5Chunk> chunks_;
  std::array<Axis, 3> axes_;  ///< the slowest first
  /// The number of the part's first chunk, and the part's first element in each chunk.
  uint64_t first_chunk_ = 0, first_element_ = 0;
  bool is_at_edge_ = false;  ///< all chunks of the part reach beyond the end of an axis
  uint64_t bytes_ = 0;
  bool keeps_layer_ = false;
  uint64_t layer_z_ = kHdf5Undefined;
  std::vector<std::vector<std::byte>> layer_;
  std::vector<std::byte> single_;
  Hdf5Decoder decoder_;
};

/// An array that is not stored in chunks.
class Hdf5PlainArray : public ByteReader {
 public:
  Hdf5PlainArray(std::shared_ptr<Hdf5File> file, const Hdf5Layout& layout, const Hdf5Part& part)
      : file_(std::move(file)), sizes_(part.sizes), element_(layout.element_bytes) {
    uint64_t step = element_, first = 0;
    for (size_t i = layout.sizes.size(); i-- > 0;) {
      const auto axis = std::find(part.axes.begin(), part.axes.end(), i);
      if (axis != part.axes.end()) steps_[static_cast<size_t>(axis - part.axes.begin())] = step;
      first += part.at[i] * step;
      step *= layout.sizes[i];
    }
    address_ = layout.address + first;
    bytes_ = element_ * sizes_[0] * sizes_[1] * sizes_[2];
  }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_ || out.size() > bytes_ - offset) {
      return fail(Status::truncated, fmt::format("{}: expected bytes of the array, found its end",
                                                 file_->path().string()));
    }
    const uint64_t row = sizes_[2] * element_;
    while (!out.empty()) {
      const uint64_t in_row = offset % row, y = offset / row % sizes_[1],
                     z = offset / row / sizes_[1];
      const auto count = static_cast<size_t>(std::min<uint64_t>(out.size(), row - in_row));
      const uint64_t begin = address_ + z * steps_[0] + y * steps_[1];
      auto read = steps_[2] == element_ ? file_->read_data(begin + in_row, out.first(count))
                                        : gather(begin, in_row, out.first(count));
      if (!read) return read;
      out = out.subspan(count);
      offset += count;
    }
    return {};
  }

  bool is_random_access() const override { return true; }
  uint64_t size_limit() const override { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    return std::min(max_count, bytes_ - std::min(offset, bytes_));
  }
  uint64_t available_bytes() override { return bytes_; }
  std::vector<std::filesystem::path> files() const override { return {file_->path()}; }

 private:
  /// Copies the bytes of a row whose elements are not adjacent.
  Result<void> gather(uint64_t begin, uint64_t in_row, std::span<std::byte> out) {
    const uint64_t first = in_row / element_, last = (in_row + out.size() - 1) / element_;
    spread_.resize(static_cast<size_t>((last - first) * steps_[2] + element_));
    if (auto read = file_->read_data(begin + first * steps_[2], spread_); !read) return read;
    for (size_t i = 0; i < out.size(); ++i) {
      const uint64_t at = in_row + i;
      out[i] = spread_[static_cast<size_t>((at / element_ - first) * steps_[2] + at % element_)];
    }
    return {};
  }

  std::shared_ptr<Hdf5File> file_;
  std::array<uint64_t, 3> sizes_, steps_{};  ///< the slowest first; steps in bytes
  uint64_t element_ = 1, address_ = 0, bytes_ = 0;
  std::vector<std::byte> spread_;
};

}  // namespace

Result<std::unique_ptr<ByteReader>> open_hdf5_array(std::shared_ptr<Hdf5File> file,
                                                    Hdf5Layout layout, Hdf5Part part) {
  if (layout.index == Hdf5Layout::Index::none) {
    return std::make_unique<Hdf5PlainArray>(std::move(file), layout, part);
  }
  auto chunks = read_hdf5_chunks(*file, layout);
  if (!chunks) return tl::unexpected(chunks.error());
  if (chunks->empty())
    return file->malformed("expected an array with elements, found none written");
  return std::make_unique<Hdf5Array>(std::move(file), std::move(layout), part, std::move(*chunks));
}

Result<std::optional<std::vector<double>>> hdf5_small_array(const std::shared_ptr<Hdf5File>& file,
                                                            const Hdf5Object& object,
                                                            std::vector<uint64_t>& sizes) {
  constexpr uint64_t kMaxNumbers = uint64_t{1} << 20;
  if (!object.find(Hdf5Kind::layout)) return std::nullopt;
  const auto elements = hdf5_elements(*file, object);
  if (!elements) return tl::unexpected(elements.error());
  const auto& type = elements->type;
  if (!elements->sizes || !type || type->kind != Hdf5Type::Kind::number) return std::nullopt;
  sizes = *elements->sizes;
  uint64_t count = 1;
  for (const uint64_t size : sizes) {
    if (size == 0 || size > kMaxNumbers) return std::nullopt;
    count *= size;
    if (count > kMaxNumbers) return std::nullopt;
  }
  auto layout = read_hdf5_layout(*file, object, sizes, type->bytes);
  if (!layout) return tl::unexpected(layout.error());
  if (layout->address == kHdf5Undefined) return std::nullopt;
  const size_t axes = sizes.size();
  const auto bytes = static_cast<size_t>(type->bytes);
  std::vector<std::byte> raw(static_cast<size_t>(count) * bytes);
  if (layout->index == Hdf5Layout::Index::none) {
    auto read = file->read(layout->address, raw.size());
    if (!read) return tl::unexpected(read.error());
    raw = std::move(*read);
  } else if (axes > 3) {
    return std::nullopt;
  } else {
    Hdf5Part part{{kNoHdf5Axis, kNoHdf5Axis, kNoHdf5Axis}, {1, 1, 1}, std::vector<uint64_t>(axes)};
    for (size_t i = 0; i < axes; ++i) {
      part.axes[3 - axes + i] = i;
      part.sizes[3 - axes + i] = sizes[i];
    }
    auto array = open_hdf5_array(file, std::move(*layout), part);
    if (!array) return tl::unexpected(array.error());
    if (auto read = (*array)->read(0, raw); !read) return tl::unexpected(read.error());
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < count; ++i) {
    numbers.push_back(hdf5_number(type->stored, std::span(raw).subspan(i * bytes, bytes)));
  }
  return numbers;
}

}  // namespace isosplat::import
