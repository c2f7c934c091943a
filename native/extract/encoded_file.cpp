#include "native/extract/encoded_file.h"

namespace isosplat {

Result<EncodedFile> EncodedFile::create(const std::filesystem::path& path,
                                        std::unique_ptr<MeshEncoder> encoder) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  return EncodedFile(std::move(*file), path.parent_path(), std::move(encoder));
}

Result<void> EncodedFile::append(const MeshPart& part) {
  part_.body.clear();
  part_.tail.clear();
  if (auto encoded = encoder_->append(part, part_); !encoded) return encoded;
  if (auto written = file_.write(end_, part_.body); !written) return written;
  end_ += part_.body.size();
  if (part_.tail.empty()) return {};
  if (!tail_) {
    auto spooled = SpooledBytes::create(folder_);
    if (!spooled) return tl::unexpected(spooled.error());
    tail_ = std::move(*spooled);
  }
  return tail_->append(part_.tail);
}

Result<void> EncodedFile::next_object() {
  encoder_->next_object();
  return {};
}

Result<void> EncodedFile::publish() {
  if (tail_) {
    auto copied = tail_->read([&](std::span<const std::byte> piece) {
      auto written = file_.write(end_, piece);
      end_ += piece.size();
      return written;
    });
    if (!copied) return copied;
  }
  std::vector<std::byte> rest;
  encoder_->finish(rest);
  if (auto written = file_.write(end_, rest); !written) return written;
  end_ += rest.size();
  const std::vector<std::byte> header = encoder_->header();
  if (auto written = file_.write(0, header); !written) return written;
  // The header of a mesh without triangles may be shorter.
  if (end_ == encoder_->header_bytes()) end_ = header.size();
  return file_.publish();
}

}  // namespace isosplat
