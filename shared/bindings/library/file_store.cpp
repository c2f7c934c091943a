#include "isosplat/file_store.h"

#include "shared/bindings/library/convert.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

struct FileStore::State {
  std::shared_ptr<StoreFile> file;
  Volume volume;
};

FileStore::FileStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
FileStore::FileStore(FileStore&&) noexcept = default;
FileStore& FileStore::operator=(FileStore&&) noexcept = default;
FileStore::~FileStore() = default;

Result<FileStore> FileStore::open(const std::filesystem::path& path) {
  auto file = StoreFile::open(path);
  if (!file) return tl::unexpected(std::move(file.error()));
  Volume volume = volume_of((*file)->info());
  return FileStore(std::make_unique<State>(State{std::move(*file), volume}));
}

const Volume& FileStore::volume() const {
  return state_->volume;
}

std::string_view FileStore::metadata() const {
  return state_->file->info().metadata;
}

Result<std::vector<Chunk>> FileStore::chunks_for(uint32_t level, double isovalue) const {
  if (auto checked = check_query(state_->volume, level, isovalue); !checked) {
    return tl::unexpected(std::move(checked.error()));
  }
  const float quantized_isovalue = state_->file->info().mapping.quantized_isovalue(isovalue);
  const auto selection = state_->file->chunks_for(level, quantized_isovalue, quantized_isovalue);
  if (!selection) return tl::unexpected(selection.error());
  return chunks_of(selection->chunks);
}

Result<std::vector<std::byte>> FileStore::read_chunk(const Chunk& chunk) const {
  std::vector<std::byte> bytes;
  auto read = state_->file->read_chunk(chunk_ref_of(chunk), bytes);
  if (!read) return tl::unexpected(std::move(read.error()));
  return bytes;
}

}  // namespace isosplat
