#include "native/builder/shared_slabs.h"

#include <algorithm>
#include <new>

namespace isosplat {

SlabChunk SharedSlabs::encode_slab(ChunkEncoder& encoder, const OpenBlock& block, size_t slab,
                                   std::vector<std::byte>& bytes) {
  const size_t before = bytes.size();
  const uint32_t begin = slab > 0 ? block.ends[slab - 1] : block.begin, end = block.ends[slab];
  const uint32_t cells = encoder.encode(block.view, block.masks[slab], begin, end, bytes);
  return {end, cells, static_cast<uint32_t>(bytes.size() - before)};
}

void SharedSlabs::encode(ChunkEncoder& encoder, const BlockView& view, const SlabMasks& masks,
                         uint32_t begin, std::span<const uint32_t> ends,
                         std::vector<SlabChunk>& slabs, std::vector<std::byte>& bytes) {
  OpenBlock block{view, masks, begin, ends, 0, ends.size(), 0, {}, {}};
  std::unique_lock lock(mutex_);
  try {
    block.slabs.reserve(ends.size());
    block.chunks.reserve(ends.size());
    if (!ends.empty()) open_.push_back(&block);
    changed_.notify_all();
    while (block.next < block.helped) {
      const size_t slab = block.next++;
      if (block.next == block.helped) std::erase(open_, &block);
      lock.unlock();
      slabs.push_back(encode_slab(encoder, block, slab, bytes));
      lock.lock();
    }
  } catch (...) {
    if (!lock) lock.lock();
    close(block, lock);
    throw;
  }
  close(block, lock);
  if (block.out_of_memory) throw std::bad_alloc();
  for (size_t i = block.slabs.size(); i-- > 0;) {
    slabs.push_back(block.slabs[i]);
    bytes.insert(bytes.end(), block.chunks[i].begin(), block.chunks[i].end());
  }
}

void SharedSlabs::close(OpenBlock& block, std::unique_lock<std::mutex>& lock) {
  std::erase(open_, &block);
  changed_.wait(lock, [&] { return block.helpers == 0; });
}

void SharedSlabs::help(ChunkEncoder& encoder) noexcept {
  std::unique_lock lock(mutex_);
  --busy_;
  changed_.notify_all();
  for (;;) {
    changed_.wait(lock, [&] { return !open_.empty() || busy_ == 0; });
    if (open_.empty()) return;
    OpenBlock& block = *open_.front();
    const size_t slab = --block.helped, place = block.slabs.size();
    if (block.next == block.helped) std::erase(open_, &block);
    ++block.helpers;
    // Within what encode() has reserved.
    block.slabs.emplace_back();
    block.chunks.emplace_back();
    lock.unlock();
    SlabChunk chunk;
    std::vector<std::byte> bytes;
    bool is_encoded = true;
    try {
      chunk = encode_slab(encoder, block, slab, bytes);
    } catch (const std::bad_alloc&) {
      is_encoded = false;
    }
    lock.lock();
    block.slabs[place] = chunk;
    block.chunks[place] = std::move(bytes);
    block.out_of_memory = block.out_of_memory || !is_encoded;
    if (--block.helpers == 0) changed_.notify_all();
  }
}

}  // namespace isosplat
