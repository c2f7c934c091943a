#include "native/builder/shared_bands.h"

#include <algorithm>
#include <new>

namespace isosplat {

BandChunk SharedBands::encode_one(ChunkEncoder& encoder, const OpenBlock& block, size_t band,
                                  std::vector<std::byte>& bytes) {
  const uint32_t begin = band > 0 ? block.ends[band - 1] : block.begin;
  return encode_band(encoder, block.voxels, block.masks[band], begin, block.ends[band], bytes);
}

void SharedBands::encode(ChunkEncoder& encoder, const BlockVoxels& voxels, const BandMasks& masks,
                         uint32_t begin, std::span<const uint32_t> ends,
                         std::vector<BandChunk>& bands, std::vector<std::byte>& bytes) {
  OpenBlock block{voxels, masks, begin, ends, 0, ends.size(), 0, {}, {}};
  std::unique_lock lock(mutex_);
  try {
    block.bands.reserve(ends.size());
    block.chunks.reserve(ends.size());
    if (!ends.empty()) open_.push_back(&block);
    changed_.notify_all();
    while (block.next < block.end) {
      const size_t band = block.next++;
      if (block.next == block.end) std::erase(open_, &block);
      lock.unlock();
      bands.push_back(encode_one(encoder, block, band, bytes));
      lock.lock();
    }
  } catch (...) {
    if (!lock) lock.lock();
    close(block, lock);
    throw;
  }
  close(block, lock);
  if (block.out_of_memory) throw std::bad_alloc();
  for (size_t i = block.bands.size(); i-- > 0;) {
    bands.push_back(block.bands[i]);
    bytes.insert(bytes.end(), block.chunks[i].begin(), block.chunks[i].end());
  }
}

void SharedBands::close(OpenBlock& block, std::unique_lock<std::mutex>& lock) {
  std::erase(open_, &block);
  changed_.wait(lock, [&] { return block.helpers == 0; });
}

void SharedBands::help(ChunkEncoder& encoder) noexcept {
  std::unique_lock lock(mutex_);
  --busy_;
  changed_.notify_all();
  for (;;) {
    changed_.wait(lock, [&] { return !open_.empty() || busy_ == 0; });
    if (open_.empty()) return;
    OpenBlock& block = *open_.front();
    const size_t band = --block.end, slot = block.bands.size();
    if (block.next == block.end) std::erase(open_, &block);
    ++block.helpers;
    // Cannot throw: encode() has reserved the memory.
    block.bands.emplace_back();
    block.chunks.emplace_back();
    lock.unlock();
    BandChunk chunk;
    std::vector<std::byte> bytes;
    bool is_encoded = true;
    try {
      chunk = encode_one(encoder, block, band, bytes);
    } catch (const std::bad_alloc&) {
      is_encoded = false;
    }
    lock.lock();
    block.bands[slot] = chunk;
    block.chunks[slot] = std::move(bytes);
    block.out_of_memory = block.out_of_memory || !is_encoded;
    if (--block.helpers == 0) changed_.notify_all();
  }
}

}  // namespace isosplat
