#include "shared/import/voxels/strided_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace isosplat::import {
namespace {

/// Bytes of a row with gaps that are read at once.
constexpr uint64_t kMaxSpread = uint64_t{1} << 20;

class StridedReader : public ByteReader {
 public:
  StridedReader(std::unique_ptr<ByteReader> file, const StridedBytes& elements)
      : file_(std::move(file)), elements_(elements) {
    const auto& [first, element, sizes, steps] = elements_;
    bytes_ = element * sizes[0] * sizes[1] * sizes[2];
    // Adjacent elements, rows and slices are read at once.
    run_ = element;
    for (size_t axis = 3; axis-- > 0 && steps[axis] == run_;) run_ *= sizes[axis];
  }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_ || out.size() > bytes_ - offset) {
      return fail(Status::truncated, fmt::format("{}: expected bytes of the array, found its end",
                                                 files().front().string()));
    }
    while (!out.empty()) {
      const uint64_t in_run = offset % run_;
      auto count = static_cast<size_t>(std::min<uint64_t>(out.size(), run_ - in_run));
      const uint64_t begin = position(offset / elements_.element);
      if (run_ > elements_.element) {
        const uint64_t in_element = offset % elements_.element;
        auto read = file_->read(begin + in_element, out.first(count));
        if (!read) return read;
      } else {
        auto gathered = gather(begin, offset, out);
        if (!gathered) return tl::unexpected(gathered.error());
        count = *gathered;
      }
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
  std::vector<std::filesystem::path> files() const override { return file_->files(); }

 private:
  /// Where an element lies in the file.
  uint64_t position(uint64_t number) const {
    const auto& [first, element, sizes, steps] = elements_;
    return first + number % sizes[2] * steps[2] + number / sizes[2] % sizes[1] * steps[1] +
           number / sizes[2] / sizes[1] * steps[0];
  }

  /// Copies bytes of a row whose elements are not adjacent, and returns how many.
  Result<size_t> gather(uint64_t begin, uint64_t offset, std::span<std::byte> out) {
    const auto& [first, element, sizes, steps] = elements_;
    const uint64_t in_element = offset % element;
    const uint64_t left = sizes[2] - offset / element % sizes[2];
    const uint64_t wanted = (in_element + out.size() + element - 1) / element;
    const uint64_t most = std::max<uint64_t>(kMaxSpread / std::max(steps[2], element), 1);
    const uint64_t count = std::min({left, wanted, most});
    spread_.resize(static_cast<size_t>((count - 1) * steps[2] + element));
    if (auto read = file_->read(begin, spread_); !read) return tl::unexpected(read.error());
    const auto copied =
        static_cast<size_t>(std::min<uint64_t>(out.size(), count * element - in_element));
    for (size_t i = 0; i < copied; ++i) {
      const uint64_t at = in_element + i;
      out[i] = spread_[static_cast<size_t>(at / element * steps[2] + at % element)];
    }
    return copied;
  }

  std::unique_ptr<ByteReader> file_;
  StridedBytes elements_;
  uint64_t bytes_ = 0;
  uint64_t run_ = 1;  ///< adjacent bytes
  std::vector<std::byte> spread_;
};

}  // namespace

std::unique_ptr<ByteReader> read_strided(std::unique_ptr<ByteReader> file,
                                         const StridedBytes& elements) {
  return std::make_unique<StridedReader>(std::move(file), elements);
}

}  // namespace isosplat::import
