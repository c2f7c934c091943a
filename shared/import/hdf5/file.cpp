#include "shared/import/hdf5/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "shared/import/hdf5/checksums.h"
#include "shared/import/text/commands.h"

// The superblock, versions 0 to 3.
//
//  0  8 bytes  "\x89HDF\r\n\x1a\n"
//  8  u8       version
//     versions 0, 1                          versions 2, 3
//  9  u8 ×4    other versions             9  u8   bytes of an address
// 13  u8       bytes of an address       10  u8   bytes of a length
// 14  u8       bytes of a length         11  u8   flags
// 16  u16 ×2   sizes of nodes            12  address ×4: base, extension, end, root group
// 20  u32      flags                         u32  checksum (lookup3)
//     u16 ×2   version 1 only
//     address ×4: base, free space, end, driver
//     root group: address of its name, address of its object header, …
namespace isosplat::import {

std::span<const std::byte> Hdf5Fields::bytes(uint64_t count) {
  if (count > rest_.size()) {
    is_short_ = true;
    rest_ = {};
    return {};
  }
  const auto taken = rest_.first(static_cast<size_t>(count));
  rest_ = rest_.subspan(static_cast<size_t>(count));
  return taken;
}

std::string_view Hdf5Fields::text(uint64_t count) {
  const auto taken = bytes(count);
  return {reinterpret_cast<const char*>(taken.data()), taken.size()};
}

uint64_t Hdf5Fields::number(uint64_t count) {
  uint64_t value = 0;
  const auto taken = bytes(count);
  for (size_t i = 0; i < taken.size(); ++i) value |= static_cast<uint64_t>(taken[i]) << 8 * i;
  return value;
}

uint64_t Hdf5Fields::defined(uint64_t count) {
  const auto taken = bytes(count);
  uint64_t value = 0;
  bool is_defined = taken.empty();
  for (size_t i = 0; i < taken.size(); ++i) {
    value |= static_cast<uint64_t>(taken[i]) << 8 * i;
    is_defined = is_defined || taken[i] != std::byte{0xff};
  }
  return is_defined ? value : kHdf5Undefined;
}

Result<Hdf5File> Hdf5File::open(const std::filesystem::path& path) {
  Hdf5File file;
  file.path_ = path;
  auto reader = open_plain(path);
  if (!reader) return tl::unexpected(reader.error());
  file.reader_ = std::move(*reader);
  // Structures are read about twice: when volumes are listed, and when one is opened.
  constexpr uint64_t kTimes = 8, kLeast = uint64_t{1} << 20;
  file.budget_ = std::min(file.bytes(), kHdf5Undefined / (2 * kTimes)) * kTimes + kLeast;
  if (auto read = file.read_superblock(); !read) return tl::unexpected(read.error());
  return file;
}

Result<void> Hdf5File::read_superblock() {
  std::array<char, 8> signature{};
  uint64_t begin = 0;
  for (const uint64_t place : kHdf5SuperblockPlaces) {
    begin = place;
    auto read = reader_->read(place, std::as_writable_bytes(std::span(signature)));
    if (!read) return tl::unexpected(read.error());
    if (std::string_view(signature.data(), 8) == kHdf5Signature) break;
  }
  const auto head = read(begin + 8, 8);
  if (!head) return tl::unexpected(head.error());
  Hdf5Fields first = fields(*head);
  const uint64_t version = first.number(1);
  if (version > 3) {
    return unsupported(fmt::format("version {} of the superblock", version));
  }
  if (version < 2) first.skip(4);
  address_bytes_ = static_cast<size_t>(first.number(1));
  length_bytes_ = static_cast<size_t>(first.number(1));
  for (const size_t size : {address_bytes_, length_bytes_}) {
    if (size != 2 && size != 4 && size != 8) {
      return malformed(
          fmt::format("expected addresses and lengths of 2, 4 or 8 bytes, found {}", size));
    }
  }
  const size_t before = version == 0 ? 24 : version == 1 ? 28 : 12;
  const auto all = read(begin, before + 6 * address_bytes_);
  if (!all) return tl::unexpected(all.error());
  Hdf5Fields rest = fields(*all);
  rest.skip(before);
  base_ = rest.address();
  rest.skip(address_bytes_);
  const uint64_t end = rest.address();
  if (version < 2) rest.skip(2 * address_bytes_);
  root_ = rest.address();
  if (version >= 2) {
    const size_t size = before + 4 * address_bytes_;
    const auto stated = static_cast<uint32_t>(rest.number(4));
    if (stated != hdf5_lookup3(std::span(*all).first(size))) {
      return malformed("the checksum of the superblock differs");
    }
  }
  if (base_ != 0 && base_ != begin) {
    return malformed(fmt::format("expected a base address of 0 or {}, found {}", begin, base_));
  }
  // The end does not count the user block in files that have got one later (h5jam).
  if (end != kHdf5Undefined && end > bytes()) {
    return fail(Status::truncated,
                fmt::format("{}: expected {} bytes, found {}: the file is incomplete; copy or "
                            "download it again",
                            path_.string(), end, bytes()));
  }
  return {};
}

Result<std::vector<std::byte>> Hdf5File::read(uint64_t address, uint64_t count) {
  if (address == kHdf5Undefined || address > kHdf5Undefined - base_ || count > bytes() ||
      base_ + address > bytes() - count) {
    return malformed(
        fmt::format("expected {} bytes at {}, found a file of {}", count, address, bytes()));
  }
  constexpr uint64_t kMaxBytes = uint64_t{256} << 20;
  if (count > budget_ || count > kMaxBytes)
    return malformed("its structures refer to each other without an end");
  budget_ -= count;
  std::vector<std::byte> out(static_cast<size_t>(count));
  auto read = reader_->read(base_ + address, out);
  if (!read) return tl::unexpected(read.error());
  return out;
}

tl::unexpected<Error> Hdf5File::malformed(const std::string& what) const {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the file is damaged, or was not closed; copy or download it "
                          "again",
                          path_.string(), what));
}

tl::unexpected<Error> Hdf5File::unsupported(const std::string& found) const {
  return fail(
      Status::unsupported_format,
      fmt::format("{}: expected an array that Isosplat reads, found {}: save the largest array of "
                  "the file for NumPy with python3 -c \"import sys, h5py, numpy; a = []; "
                  "h5py.File(sys.argv[1]).visititems(lambda _, o: a.append(o) if hasattr(o, "
                  "'shape') else None); numpy.save('volume.npy', max(a, key=lambda o: o.size)"
                  "[...])\" {}",
                  path_.string(), found, shell_word(path_)));
}

}  // namespace isosplat::import
