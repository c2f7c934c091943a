#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/core/codec/bit_stream.h"
#include "shared/core/codec/chunk_header.h"
#include "shared/core/codec/chunk_tables.h"
#include "shared/core/codec/rans.h"
#include "shared/core/codec/residual_model.h"

namespace isosplat {

/// A token distribution: the token of each slot, and the frequency and start of each token.
struct TokenTable {
  bool built = false;
  uint8_t token[2048];
  uint16_t frequency[kTokens];
  uint16_t start[kTokens];

  void build(uint32_t shape) {
    read_distribution(kTokenTable[shape], kTokens, kTokenTotal, frequency);
    uint32_t next = 0;
    for (uint32_t t = 0; t < kTokens; ++t) {
      start[t] = static_cast<uint16_t>(next);
      std::fill_n(token + next, frequency[t], static_cast<uint8_t>(t));
      next += frequency[t];
    }
    built = true;
  }
};

/// The decoding table of a context. Contexts share the slots, so that all tables in use fit the
/// cache.
struct ContextModel {
  /// The smallest u of a token, and the number of raw bits that follow.
  struct Entry {
    uint32_t frequency, start, min_folded, raw_bits;
  };
  const uint8_t* token_of_slot = nullptr;
  Entry entry[kTokens];

  void set(const TokenTable& table, uint32_t shift) {
    token_of_slot = table.token;
    for (uint32_t t = 0; t < kTokens; ++t) {
      const uint32_t info = kTokenInfo.info[t];
      entry[t] = {table.frequency[t], table.start[t], (info & 0xffffff) << shift,
                  (info >> 24) + shift};
    }
  }
};

/// The decoding tables of the models that a chunk's header selects. Keeps built tables for later
/// chunks.
class ResidualModels {
 public:
  /// Returns false if the header has no model.
  bool set(const ChunkHeader& header) {
    int32_t any = -1;
    for (int32_t c = 0; c < kContexts; ++c) {
      if (header.model[c] == kNoModel) continue;
      const Model model = model_of(header.model[c]);
      TokenTable& table = tables_[model.shape];
      if (!table.built) table.build(model.shape);
      of_context_[c].set(table, model.shift);
      any = c;
    }
    if (any < 0) return false;
    // A malformed chunk may use a context without a model: it gets an arbitrary one.
    for (int32_t key = 0; key < kKeys; ++key) {
      const int32_t c = header.levels.context_of_key(key);
      of_key_[key] = &of_context_[header.model[c] == kNoModel ? any : c];
    }
    return true;
  }

  /// By residual_key().
  const ContextModel& operator[](int32_t key) const { return *of_key_[key]; }

 private:
  TokenTable tables_[kShapes];
  ContextModel of_context_[kContexts];
  const ContextModel* of_key_[kKeys];
};

/// The two streams of a chunk, which begin at its two ends.
struct ChunkStreams {
  BitReader bits;
  RansDecoder rans;

  /// Whether the two streams have not passed each other.
  bool within() const { return bits.position() <= rans.position(); }

  int32_t residual(const ContextModel& model) {
    const uint32_t token = rans.get<11>([&](uint32_t slot) {
      const uint32_t found = model.token_of_slot[slot];
      return FoundSymbol{model.entry[found].start, model.entry[found].frequency, found};
    });
    const ContextModel::Entry& entry = model.entry[token];
    return unfold(entry.min_folded + bits.get(entry.raw_bits));
  }
};

}  // namespace isosplat
