#include "native/build/shared_slabs.h"

#include <algorithm>

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
  if (!ends.empty()) open_.push_back(&block);
  changed_.notify_all();
  while (block.next < block.helped) {
    const size_t slab = block.next++;
    if (block.next == block.helped) std::erase(open_, &block);
    lock.unlock();
    slabs.push_back(encode_slab(encoder, block, slab, bytes));
    lock.lock();
  }
  changed_.wait(lock, [&] { return block.helpers == 0; });
  for (size_t i = block.slabs.size(); i-- > 0;) {
    slabs.push_back(block.slabs[i]);
    bytes.insert(bytes.end(), block.chunks[i].begin(), block.chunks[i].end());
  }
}

void SharedSlabs::help(ChunkEncoder& encoder) {
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
    block.slabs.emplace_back();
    block.chunks.emplace_back();
    lock.unlock();
    std::vector<std::byte> bytes;
    const SlabChunk chunk = encode_slab(encoder, block, slab, bytes);
    lock.lock();
    block.slabs[place] = chunk;
    block.chunks[place] = std::move(bytes);
    if (--block.helpers == 0) changed_.notify_all();
  }
}

}  // namespace isosplat
