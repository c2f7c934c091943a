#include <fmt/format.h>
#include <zlib.h>

#include "tests/conformance/sample.h"

// Written from APPNOTE.TXT (ZIP) and numpy.lib.npyio: numpy.savez, savez_compressed.
namespace isosplat::conformance {
namespace {

/// Deflated data without a container.
std::string deflated(const std::string& bytes) {
  const std::string zlib = gzipped(bytes, true);
  return zlib.substr(2, zlib.size() - 6);
}

/// Writes an archive. `is_wide`: with 64-bit sizes, as NumPy writes them.
class Archive {
 public:
  Archive(bool is_packed, bool is_wide) : is_packed_(is_packed), is_wide_(is_wide) {}

  void add(const std::string& name, const std::string& content) {
    const std::string stored = is_packed_ ? deflated(content) : content;
    const auto checksum = static_cast<uint32_t>(crc32(
        0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
    const auto header = static_cast<uint64_t>(bytes_.size());
    // Version, flags, method, time, date, checksum, sizes; then the lengths of name and extra
    // field.
    const auto fields = [&](std::string& out) {
      for (const int value : {is_wide_ ? 45 : 20, 0, is_packed_ ? 8 : 0, 0, 33}) {
        put(out, static_cast<uint16_t>(value), false);
      }
      put(out, checksum, false);
      for (const size_t size : {stored.size(), content.size()}) {
        put(out, is_wide_ ? UINT32_MAX : static_cast<uint32_t>(size), false);
      }
      put(out, static_cast<uint16_t>(name.size()), false);
    };
    const auto extra = [&](bool with_header) {
      std::string out;
      if (!is_wide_) return out;
      put(out, uint16_t{1}, false);
      put(out, static_cast<uint16_t>(with_header ? 24 : 16), false);
      put(out, static_cast<uint64_t>(content.size()), false);
      put(out, static_cast<uint64_t>(stored.size()), false);
      if (with_header) put(out, header, false);
      return out;
    };
    bytes_ += "PK\3\4";
    fields(bytes_);
    put(bytes_, static_cast<uint16_t>(extra(false).size()), false);
    bytes_ += name + extra(false) + stored;
    directory_ += "PK\1\2";
    put(directory_, uint16_t{45}, false);
    fields(directory_);
    put(directory_, static_cast<uint16_t>(extra(true).size()), false);
    for (int i = 0; i < 3; ++i) put(directory_, uint16_t{0}, false);  // comment, disk, attributes
    put(directory_, uint32_t{0}, false);
    put(directory_, is_wide_ ? UINT32_MAX : static_cast<uint32_t>(header), false);
    directory_ += name + extra(true);
    ++count_;
  }

  std::string file() const {
    std::string out = bytes_ + directory_;
    if (is_wide_) {
      const auto at = static_cast<uint64_t>(out.size());
      out += "PK\6\6";
      put(out, uint64_t{44}, false);
      for (int i = 0; i < 2; ++i) put(out, uint16_t{45}, false);
      for (int i = 0; i < 2; ++i) put(out, uint32_t{0}, false);
      for (const uint64_t number : {uint64_t{count_}, uint64_t{count_}, uint64_t{directory_.size()},
                                    uint64_t{bytes_.size()}}) {
        put(out, number, false);
      }
      out += "PK\6\7";
      put(out, uint32_t{0}, false);
      put(out, at, false);
      put(out, uint32_t{1}, false);
    }
    out += "PK\5\6";
    for (int i = 0; i < 2; ++i) put(out, uint16_t{0}, false);
    for (int i = 0; i < 2; ++i) put(out, is_wide_ ? uint16_t{0xffff} : count_, false);
    for (const size_t number : {directory_.size(), bytes_.size()}) {
      put(out, is_wide_ ? UINT32_MAX : static_cast<uint32_t>(number), false);
    }
    put(out, uint16_t{0}, false);
    return out;
  }

 private:
  bool is_packed_, is_wide_;
  std::string bytes_, directory_;
  uint16_t count_ = 0;
};

}  // namespace

Sample make_npz(Random& random) {
  Sample sample = make_npy(random);
  const std::string volume = sample.files["v.npy"];
  const bool is_packed = random.chance(50), is_wide = random.chance(50);
  const bool has_another = random.chance(50), has_names = random.chance(50);
  std::string list = "\x93NUMPY";
  const std::string dictionary = "{'descr': '|u1', 'fortran_order': False, 'shape': (4,), }\n";
  list += {'\1', '\0', static_cast<char>(dictionary.size()), '\0'};
  list += dictionary + "abcd";
  Archive archive(is_packed, is_wide);
  if (has_names) archive.add("names.npy", list);
  if (has_another && random.chance(50)) archive.add("other.npy", volume);
  archive.add("density.npy", volume);
  if (has_another) {
    archive.add("another.npy", volume);
    sample.options.dataset = random.one_of({"density", "density.npy"});
    sample.needs_choice = true;
  }
  sample.files = {{"v.npz", archive.file()}};
  sample.main = "v.npz";
  sample.may_be_longer = true;  // an archive may have a comment
  sample.text += fmt::format(", in an archive{}{}{}", is_packed ? ", packed" : "",
                             is_wide ? ", 64 bits" : "", has_another ? ", several" : "");
  sample.damages.clear();
  sample.damages.push_back([](auto& files) {  // another method
    std::string& bytes = files["v.npz"];
    bytes[bytes.rfind("density.npy") - 36] = 12;
  });
  sample.damages.push_back([](auto& files) {  // another offset
    std::string& bytes = files["v.npz"];
    bytes[bytes.rfind("density.npy") - 4] ^= 1;
  });
  return sample;
}

}  // namespace isosplat::conformance
