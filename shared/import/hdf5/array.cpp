#include "shared/import/hdf5/array.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/filters.h"
#include "shared/import/hdf5/type.h"
#include "shared/import/voxels/strided_reader.h"

namespace isosplat::import {
namespace {

class Hdf5Array : public ChunkedReader {
 public:
  Hdf5Array(std::shared_ptr<Hdf5File> file, Hdf5Layout layout, const ArrayPart& part,
            std::vector<Hdf5Chunk> chunks)
      : ChunkedReader(file->path().string(), grid_of(layout), part),
        file_(std::move(file)),
        layout_(std::move(layout)),
        chunks_(std::move(chunks)) {}

  uint64_t resident_bytes() const override {
    return ChunkedReader::resident_bytes() + chunks_.size() * sizeof(Hdf5Chunk);
  }
  std::vector<std::filesystem::path> files() const override { return {file_->path()}; }

 private:
  static ChunkGrid grid_of(const Hdf5Layout& layout) {
    return {layout.sizes, layout.chunk, layout.element_bytes, layout.fill};
  }

  Result<std::vector<std::byte>> decode(uint64_t number, bool is_at_edge) override {
    const auto found = std::lower_bound(
        chunks_.begin(), chunks_.end(), number,
        [](const Hdf5Chunk& chunk, uint64_t sought) { return chunk.number < sought; });
    if (found == chunks_.end() || found->number != number) return std::vector<std::byte>{};
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
    if (layout_.has_plain_edges && is_at_edge) mask = ~uint32_t{0};
    return decoder_.decode(*file_, layout_, std::move(stored), mask);
  }

  std::shared_ptr<Hdf5File> file_;
  Hdf5Layout layout_;
  std::vector<Hdf5Chunk> chunks_;
  Hdf5Decoder decoder_;
};

/// The elements of an array that is not stored in chunks.
StridedBytes plain_elements(const Hdf5File& file, const Hdf5Layout& layout, const ArrayPart& part) {
  StridedBytes elements{
      .first = file.base() + layout.address, .element = layout.element_bytes, .sizes = part.sizes};
  uint64_t step = layout.element_bytes;
  for (size_t i = layout.sizes.size(); i-- > 0;) {
    const auto axis = std::find(part.axes.begin(), part.axes.end(), i);
    if (axis != part.axes.end()) {
      elements.steps[static_cast<size_t>(axis - part.axes.begin())] = step;
    }
    elements.first += part.at[i] * step;
    step *= layout.sizes[i];
  }
  return elements;
}

}  // namespace

Result<std::unique_ptr<ByteReader>> open_hdf5_array(std::shared_ptr<Hdf5File> file,
                                                    Hdf5Layout layout, ArrayPart part) {
  if (layout.index == Hdf5Layout::Index::none) {
    auto plain = open_plain(file->path());
    if (!plain) return tl::unexpected(plain.error());
    return read_strided(std::move(*plain), plain_elements(*file, layout, part));
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
    ArrayPart part{{kNoAxis, kNoAxis, kNoAxis}, {1, 1, 1}, std::vector<uint64_t>(axes)};
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
    numbers.push_back(stored_number(type->stored, std::span(raw).subspan(i * bytes, bytes)));
  }
  return numbers;
}

}  // namespace isosplat::import
