#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/bindings/wasm/core_api.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/sampling/packed_field.h"
#include "shared/core/sampling/sample_clusters.h"
#include "shared/core/select/selector.h"
#include "shared/core/store/store_reader.h"

// Shared by the functions of core_api.h: the state of a core, its errors and its result buffers.

/// An open store, or just a decoder, with the results of the last call.
struct IsosplatCore {
  std::unique_ptr<isosplat::StoreReader> store;
  std::optional<isosplat::Selector> selector;
  isosplat::ChunkDecoder decoder;
  std::vector<isosplat::PackedSample> packed, ordered;
  std::vector<isosplat::SampleCluster> clusters;
  isosplat::DecodedCells cells;
  std::vector<isosplat::PackedField> field;
  std::string error;
  std::array<std::vector<std::byte>, ISOSPLAT_RESULT_BUFFERS> copies;
  /// Each is in `copies` or in another member.
  std::array<std::span<const std::byte>, ISOSPLAT_RESULT_BUFFERS> results;
};

namespace isosplat::wasm {

inline constexpr IsosplatStatus kOk = static_cast<IsosplatStatus>(Status::ok);

/// Sets the message of the last error, and returns its status.
IsosplatStatus report(IsosplatCore* core, const Error& error);
IsosplatStatus report(IsosplatCore* core, Status status, std::string message);

/// The error of a function that needs an open store.
IsosplatStatus no_store(IsosplatCore* core);

inline std::span<const std::byte> as_bytes(const void* data, uint32_t bytes) {
  return {static_cast<const std::byte*>(data), bytes};
}

/// Copies items to a result buffer.
template <class T>
void put(IsosplatCore* core, size_t buffer, const T* items, size_t count) {
  const auto bytes = std::as_bytes(std::span(items, count));
  core->copies[buffer].assign(bytes.begin(), bytes.end());
  core->results[buffer] = core->copies[buffer];
}

template <class Container>
void put(IsosplatCore* core, size_t buffer, const Container& items) {
  put(core, buffer, items.data(), items.size());
}

template <class Record>
void put_record(IsosplatCore* core, size_t buffer, const Record& record) {
  put(core, buffer, &record, 1);
}

Index3 as_index(const uint32_t* words);
void copy_index(const Index3& index, uint32_t* words);

/// A chunk of the open store. Gives it a handle if it has none.
IsosplatChunk chunk_record(IsosplatCore* core, const ChunkRef& chunk);

}  // namespace isosplat::wasm
