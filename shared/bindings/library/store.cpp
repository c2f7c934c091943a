#include "isosplat/store.h"

#include <cmath>

#include "shared/bindings/library/convert.h"

namespace isosplat {

static_assert(kMaxHeaderBytes == kMaxStoreHeaderBytes);

struct Store::State {
  StoreReader reader;
  Volume volume;

  float quantized_isovalue(double isovalue) const {
    return reader.info().mapping.quantized_isovalue(isovalue);
  }
};

Store::Store(std::unique_ptr<State> state) : state_(std::move(state)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

Result<Store> Store::open(std::span<const std::byte> header) {
  Result<StoreReader> reader = StoreReader::open(header);
  if (!reader) return tl::unexpected(std::move(reader.error()));
  Volume volume = volume_of(reader->info());
  return Store(std::make_unique<State>(State{std::move(*reader), volume}));
}

const Volume& Store::volume() const {
  return state_->volume;
}

uint64_t Store::file_bytes() const {
  return state_->reader.info().file_bytes;
}

std::string_view Store::metadata() const {
  return state_->reader.info().metadata;
}

std::vector<Page> Store::missing_pages(uint32_t level, double isovalue) const {
  if (!check_query(state_->volume, level, isovalue)) return {};
  const float quantized_isovalue = state_->quantized_isovalue(isovalue);
  std::vector<Page> pages;
  for (const uint32_t index :
       state_->reader.missing_pages(level, quantized_isovalue, quantized_isovalue)) {
    const PageRef& ref = state_->reader.pages()[index];
    pages.push_back({index, ref.offset, ref.bytes});
  }
  return pages;
}

Result<void> Store::add_page(uint32_t page, std::span<const std::byte> bytes) {
  return state_->reader.add_page(page, bytes);
}

Result<std::vector<Chunk>> Store::chunks_for(uint32_t level, double isovalue) const {
  if (auto checked = check_query(state_->volume, level, isovalue); !checked) {
    return tl::unexpected(std::move(checked.error()));
  }
  const float quantized_isovalue = state_->quantized_isovalue(isovalue);
  return state_->reader.chunks_for(level, quantized_isovalue, quantized_isovalue).map(chunks_of);
}

}  // namespace isosplat
