#include "shared/import/dicom/elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "shared/import/codecs/deflated_reader.h"

namespace isosplat::import::dicom {
namespace {

constexpr Tag kItem = 0xfffee000;
constexpr Tag kItemEnd = 0xfffee00d;
constexpr Tag kSequenceEnd = 0xfffee0dd;
constexpr uint32_t kUndefinedLength = 0xffffffff;

/// Limits for the length of a value, the number of elements of a file and the nesting of sequences.
/// They are hundreds of times the sizes in real files.
constexpr uint64_t kMaxValueBytes = 4 << 20;
constexpr size_t kMaxElements = 4'000'000;
constexpr int kMaxDepth = 32;

/// The encoding of a data set.
struct Syntax {
  bool is_explicit = true;
  bool big_endian = false;
};

/// The header of an element.
///
///   implicit:              | tag (4) | length (4) |
///   explicit, short forms: | tag (4) | VR (2) | length (2) |
///   explicit, long forms:  | tag (4) | VR (2) | 0 (2) | length (4) |
struct ElementHeader {
  Tag tag = 0;
  std::array<char, 2> vr{};  ///< zeros if the file has no VR
  uint32_t length = 0;

  bool is_vr(std::string_view name) const { return std::string_view(vr.data(), 2) == name; }
};

constexpr std::string_view kLongForms[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                           "SV", "UC", "UN", "UR", "UT", "UV"};
constexpr std::string_view kShortForms[] = {"AE", "AS", "AT", "CS", "DA", "DS", "DT",
                                            "FD", "FL", "IS", "LO", "LT", "PN", "SH",
                                            "SL", "SS", "ST", "TM", "UI", "UL", "US"};

template <size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

bool is_vr(std::string_view name) {
  return contains(kLongForms, name) || contains(kShortForms, name);
}

uint16_t u16_at(const std::byte* bytes, bool big_endian) {
  uint16_t value;
  std::memcpy(&value, bytes, sizeof value);
  return big_endian ? __builtin_bswap16(value) : value;
}

uint32_t u32_at(const std::byte* bytes, bool big_endian) {
  uint32_t value;
  std::memcpy(&value, bytes, sizeof value);
  return big_endian ? __builtin_bswap32(value) : value;
}

template <class T>
void append_numbers(std::span<const std::byte> bytes, bool big_endian, std::vector<double>& out) {
  for (size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), raw.begin());
    if (big_endian) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    out.push_back(static_cast<double>(value));
  }
}

/// How a value is stored, from its VR; from the registry if there is no VR.
Kind kind_of(const ElementHeader& header, Kind registered) {
  struct Named {
    std::string_view vr;
    Kind kind;
  };
  constexpr Named kNamed[] = {{"US", Kind::u16},     {"SS", Kind::i16}, {"UL", Kind::u32},
                              {"SL", Kind::i32},     {"FL", Kind::f32}, {"FD", Kind::f64},
                              {"SQ", Kind::sequence}};
  if (header.vr[0] == 0 || header.is_vr("UN") || header.is_vr("OB") || header.is_vr("OW")) {
    return registered;
  }
  for (const Named& named : kNamed) {
    if (header.is_vr(named.vr)) return named.kind;
  }
  return Kind::text;
}

std::string name_of(Tag tag) {
  return fmt::format("({:04x},{:04x})", tag >> 16, tag & 0xffff);
}

/// Reads a data set from front to back.
class ElementReader {
 public:
  /// `end`: the end of the bytes; unknown for deflated data.
  ElementReader(ByteReader& file, const std::filesystem::path& path, uint64_t start,
                std::optional<uint64_t> end)
      : file_(file), path_(path), position_(start), end_(end) {}

  uint64_t position() const { return position_; }

  /// Reads the elements of group 2, which contain the transfer syntax.
  Result<void> read_meta(Item& out) {
    for (;;) {
      auto next = peek_tag();
      if (!next) return tl::unexpected(next.error());
      if (!*next || **next >> 16 != 2) return {};
      auto read = read_element(Syntax{}, &out, end_or_infinity(), 0);
      if (!read) return tl::unexpected(read.error());
    }
  }

  /// Detects the encoding of the data set that starts here, independent of the transfer syntax:
  /// some programs write a different encoding than they declare.
  Result<Syntax> guess_syntax(Syntax promised) {
    std::array<std::byte, 6> bytes{};
    const auto room = has(bytes.size());
    if (!room) return tl::unexpected(room.error());
    if (!*room) return promised;
    if (auto r = look(bytes); !r) return tl::unexpected(r.error());
    const uint16_t group = u16_at(bytes.data(), promised.big_endian);
    if (group > 0xff && __builtin_bswap16(group) <= 0xff) promised.big_endian ^= true;
    promised.is_explicit = is_vr({reinterpret_cast<const char*>(bytes.data()) + 4, 2});
    return promised;
  }

  /// Reads the data set up to its pixels.
  Result<void> read_data(Syntax syntax, Elements& out) {
    pixels_ = &out.pixels;
    while (out.pixels.tag == 0) {
      auto next = peek_tag();
      if (!next) return tl::unexpected(next.error());
      if (!*next) return check_end();
      if (**next == 0) return {};  // zero padding at the end of the file
      auto read = read_element(syntax, &out.data, end_or_infinity(), 0);
      if (!read) return read;
    }
    return {};
  }

 private:
  uint64_t end_or_infinity() const { return end_.value_or(std::numeric_limits<uint64_t>::max()); }

  tl::unexpected<Error> malformed(std::string_view why) const {
    return fail(Status::malformed_volume,
                fmt::format("{}: its DICOM elements are damaged near byte {} ({}): copy or export "
                            "the file again",
                            path_.string(), position_, why));
  }

  tl::unexpected<Error> ends_early(Tag tag, uint64_t needed) const {
    return fail(Status::truncated,
                fmt::format("{}: expected {} bytes for the element {}, found the end of the file: "
                            "it is incomplete; copy or download it again",
                            path_.string(), needed, name_of(tag)));
  }

  /// Whether `count` more bytes exist. If the end is unknown, large counts are checked by reading.
  Result<bool> has(uint64_t bytes) {
    if (end_) return position_ <= *end_ && bytes <= *end_ - position_;
    return bytes > kMaxPeeked ? true : fill(static_cast<size_t>(bytes));
  }

  /// Fills the window with at least this many bytes from the position on; false if the file ends
  /// first.
  Result<bool> fill(size_t bytes) {
    const uint64_t window_end = window_start_ + window_.size();
    if (position_ >= window_start_ && position_ + bytes <= window_end) return true;
    uint64_t known = bytes;
    if (end_) {
      if (position_ > *end_ || bytes > *end_ - position_) return false;
      known = std::min(std::max<uint64_t>(bytes, kWindow), *end_ - position_);
    }
    const bool overlaps = position_ >= window_start_ && position_ < window_end;
    window_.erase(window_.begin(), overlaps ? window_.begin() + static_cast<std::ptrdiff_t>(
                                                                    position_ - window_start_)
                                            : window_.end());
    window_start_ = position_;
    const size_t held = window_.size();
    window_.resize(static_cast<size_t>(known));
    const auto read = file_.read(position_ + held, std::span(window_).subspan(held));
    if (read) return true;
    window_.resize(held);
    if (!end_ && read.error().status == Status::truncated) return false;
    return tl::unexpected(read.error());
  }

  /// Copies bytes without advancing the position.
  Result<void> look(std::span<std::byte> out) {
    const auto filled = fill(out.size());
    if (!filled) return tl::unexpected(filled.error());
    if (!*filled) return ends_early(0, out.size());
    std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(position_ - window_start_),
                out.size(), out.begin());
    return {};
  }

  Result<void> read_bytes(std::span<std::byte> out) {
    auto read = look(out);
    if (read) position_ += out.size();
    return read;
  }

  /// The next tag, in the byte order that gives a group below 0x100; nothing at the end.
  Result<std::optional<Tag>> peek_tag() {
    std::array<std::byte, 4> bytes{};
    const auto room = has(bytes.size());
    if (!room) return tl::unexpected(room.error());
    if (!*room) return std::nullopt;
    if (auto r = look(bytes); !r) return tl::unexpected(r.error());
    return Tag{u16_at(bytes.data(), false)} << 16 | u16_at(bytes.data() + 2, false);
  }

  /// The end of a deflated data set: a skipped element may extend beyond it.
  Result<void> check_end() {
    std::byte last{};
    if (end_ || position_ == 0) return {};
    return file_.read(position_ - 1, std::span(&last, 1));
  }

  Result<ElementHeader> read_store_header(Syntax syntax, uint64_t end) {
    ElementHeader header;
    std::array<std::byte, 8> bytes{};
    const auto room = has(bytes.size());
    if (!room) return tl::unexpected(room.error());
    if (!*room) return ends_early(0, bytes.size());
    if (position_ + bytes.size() > end) return malformed("an element crosses the end of its item");
    if (auto r = read_bytes(bytes); !r) return tl::unexpected(r.error());
    header.tag = Tag{u16_at(bytes.data(), syntax.big_endian)} << 16 |
                 u16_at(bytes.data() + 2, syntax.big_endian);
    const std::string_view vr(reinterpret_cast<const char*>(bytes.data()) + 4, 2);
    const bool is_delimiter = header.tag >> 16 == 0xfffe;
    // Some writers mix both forms: if these bytes are no VR, they are the length of the implicit
    // form.
    if (is_delimiter || !syntax.is_explicit || !is_vr(vr)) {
      header.length = u32_at(bytes.data() + 4, syntax.big_endian);
      return header;
    }
    header.vr = {vr[0], vr[1]};
    if (!contains(kLongForms, vr)) {
      header.length = u16_at(bytes.data() + 6, syntax.big_endian);
      return header;
    }
    std::array<std::byte, 4> length{};
    const auto more = has(length.size());
    if (!more) return tl::unexpected(more.error());
    if (!*more) return ends_early(header.tag, length.size());
    if (auto r = read_bytes(length); !r) return tl::unexpected(r.error());
    header.length = u32_at(length.data(), syntax.big_endian);
    return header;
  }

  /// Reads one element into `out`, or skips it if `out` is null or the element is not in the list.
  /// `end`: of the enclosing item.
  Result<void> read_element(Syntax syntax, Item* out, uint64_t end, int depth) {
    const auto header = read_store_header(syntax, end);
    if (!header) return tl::unexpected(header.error());
    const bool is_pixels =
        header->tag == kPixels || header->tag == kFloatPixels || header->tag == kDoublePixels;
    if (is_pixels && depth == 0 && pixels_) {
      pixels_->tag = header->tag;
      pixels_->in_words = header->is_vr("OW");
      pixels_->offset = position_;
      pixels_->bytes =
          header->length == kUndefinedLength ? PixelPlace::kUndefined : uint64_t{header->length};
      return {};
    }
    if (header->tag >> 16 == 0xfffe) return malformed("an item where an element should be");

    const KnownTag* known = out ? find_known_tag(header->tag) : nullptr;
    if (out && depth == 0 && header->tag >> 16 & 1) {
      const auto found = find_private(*header);
      if (!found) return tl::unexpected(found.error());
      known = *found;
    }
    const bool is_sequence =
        header->length == kUndefinedLength ||
        (known && kind_of(*header, known->kind) == Kind::sequence && header->length > 0);
    if (is_sequence) {
      Element element;
      element.tag = known ? known->tag : header->tag;
      // A sequence with unknown VR is in the implicit form (PS3.5, 6.2.2).
      const Syntax inside =
          header->is_vr("UN") ? Syntax{.is_explicit = false, .big_endian = false} : syntax;
      auto read = read_sequence(inside, *header, known ? &element : nullptr, end, depth + 1);
      if (!read) return read;
      return known ? keep(*out, std::move(element)) : Result<void>{};
    }
    const auto room = has(header->length);
    if (!room) return tl::unexpected(room.error());
    if (!*room) return ends_early(header->tag, header->length);
    if (header->length > end - position_) return malformed("a value crosses the end of its item");
    if (!known) {
      position_ += header->length;
      return {};
    }
    if (header->length > kMaxValueBytes) return malformed(name_of(header->tag) + " is too long");
    std::vector<std::byte> bytes(header->length);
    if (auto r = read_bytes(bytes); !r) return r;
    return keep(*out, make_element(syntax, known->tag, kind_of(*header, known->kind), bytes));
  }

  /// How a private element is stored. Remembers the creator of a block, which precedes the block's
  /// elements: (gggg,00bb) reserves (gggg,bb00) to (gggg,bbff).
  Result<const KnownTag*> find_private(const ElementHeader& header) {
    const Tag group = header.tag & 0xffff0000, element = header.tag & 0xffff;
    const auto room = has(header.length);
    if (!room) return tl::unexpected(room.error());
    if (element >= 0x10 && element <= 0xff && header.length <= kMaxCreator && *room) {
      std::vector<std::byte> bytes(header.length);
      if (auto r = look(bytes); !r) return tl::unexpected(r.error());
      std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      text.erase(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
      creators_[group | element << 8] = std::move(text);
      return nullptr;
    }
    const auto creator = creators_.find(header.tag & 0xffffff00);
    if (creator == creators_.end() || header.length > kMaxValueBytes) return nullptr;
    return find_private_tag(creator->second, header.tag);
  }

  static Element make_element(Syntax syntax, Tag tag, Kind kind, std::span<const std::byte> bytes) {
    Element element;
    element.tag = tag;
    const bool swap = syntax.big_endian;
    switch (kind) {
      case Kind::text:
        element.text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        break;
      case Kind::u16:
        append_numbers<uint16_t>(bytes, swap, element.numbers);
        break;
      case Kind::i16:
        append_numbers<int16_t>(bytes, swap, element.numbers);
        break;
      case Kind::u32:
        append_numbers<uint32_t>(bytes, swap, element.numbers);
        break;
      case Kind::i32:
        append_numbers<int32_t>(bytes, swap, element.numbers);
        break;
      case Kind::f32:
        append_numbers<float>(bytes, swap, element.numbers);
        break;
      case Kind::f64:
        append_numbers<double>(bytes, swap, element.numbers);
        break;
      case Kind::sequence:
        break;
    }
    return element;
  }

  Result<void> keep(Item& out, Element element) {
    if (++kept_ > kMaxElements) return malformed("it has too many elements");
    out.elements.push_back(std::move(element));
    return {};
  }

  /// Reads the items of a sequence, or the fragments of an encapsulated value, after its header;
  /// skips them if `out` is null.
  Result<void> read_sequence(Syntax syntax, const ElementHeader& header, Element* out,
                             uint64_t outer_end, int depth) {
    if (depth > kMaxDepth) return malformed("its sequences are nested too deeply");
    uint64_t end = outer_end;
    if (header.length != kUndefinedLength) {
      const auto room = has(header.length);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return ends_early(header.tag, header.length);
      if (header.length > outer_end - position_)
        return malformed("a sequence crosses its item's end");
      end = position_ + header.length;
    }
    while (position_ < end) {
      const auto item = read_store_header(syntax, end);
      if (!item) return tl::unexpected(item.error());
      if (item->tag == kSequenceEnd) return {};
      if (item->tag != kItem) return malformed("expected an item of " + name_of(header.tag));
      Item* inside = nullptr;
      if (out) {
        if (++kept_ > kMaxElements) return malformed("it has too many elements");
        inside = &out->items.emplace_back();
      }
      if (auto r = read_item(syntax, *item, inside, end, depth); !r) return r;
    }
    if (header.length == kUndefinedLength) return ends_early(header.tag, 8);
    return {};
  }

  Result<void> read_item(Syntax syntax, const ElementHeader& item, Item* out, uint64_t sequence_end,
                         int depth) {
    if (item.length != kUndefinedLength) {
      const auto room = has(item.length);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return ends_early(kItem, item.length);
      if (item.length > sequence_end - position_)
        return malformed(
            "an item crosses the end of its "
            "sequence");
      const uint64_t end = position_ + item.length;
      while (out && position_ < end) {
        if (auto r = read_element(syntax, out, end, depth); !r) return r;
      }
      position_ = end;
      return {};
    }
    for (;;) {
      const auto room = has(8);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return ends_early(kItemEnd, 8);
      std::array<std::byte, 4> bytes{};
      if (auto r = look(bytes); !r) return r;
      const Tag tag = Tag{u16_at(bytes.data(), syntax.big_endian)} << 16 |
                      u16_at(bytes.data() + 2, syntax.big_endian);
      if (tag == kItemEnd) {
        position_ += 8;
        return {};
      }
      if (auto r = read_element(syntax, out, sequence_end, depth); !r) return r;
    }
  }

  static constexpr size_t kWindow = 8 * 1024;
  static constexpr uint64_t kMaxPeeked = 16;
  static constexpr uint32_t kMaxCreator = 64;

  ByteReader& file_;
  const std::filesystem::path& path_;
  uint64_t position_;
  std::optional<uint64_t> end_;
  PixelPlace* pixels_ = nullptr;
  size_t kept_ = 0;
  std::map<Tag, std::string> creators_;  ///< of private blocks, by their first tag
  std::vector<std::byte> window_;        ///< buffered bytes of the input
  uint64_t window_start_ = 0;
};

}  // namespace

bool looks_like_dicom(std::string_view beginning) {
  if (beginning.size() >= 132 && beginning.substr(128, 4) == "DICM") return true;
  if (beginning.size() < 16) return false;
  // Without a prefix, the first element has group 2 or 8, and a VR or a small even length.
  const auto* bytes = reinterpret_cast<const std::byte*>(beginning.data());
  for (const bool big_endian : {false, true}) {
    const uint16_t group = u16_at(bytes, big_endian);
    const uint16_t element = u16_at(bytes + 2, big_endian);
    if ((group != 2 && group != 8) || element > 0x70) continue;
    if (is_vr(beginning.substr(4, 2))) return true;
    const uint32_t length = u32_at(bytes + 4, big_endian);
    if (length <= 128 && length % 2 == 0 && 8 + length < beginning.size()) {
      const uint16_t next = u16_at(bytes + 8 + length, big_endian);
      if (next == group || next == 8) return true;
    }
  }
  return false;
}

Result<Elements> read_elements(const std::filesystem::path& path) {
  auto opened = open_plain(path);
  if (!opened) return tl::unexpected(opened.error());
  ByteReader& file = **opened;
  std::array<std::byte, 132> prefix{};
  const uint64_t size = file.size_limit();
  uint64_t start = 0;
  if (size >= prefix.size()) {
    if (auto r = file.read(0, prefix); !r) return tl::unexpected(r.error());
    if (std::memcmp(prefix.data() + 128, "DICM", 4) == 0) start = prefix.size();
  }
  Elements out;
  ElementReader walker(file, path, start, size);
  if (auto r = walker.read_meta(out.data); !r) return tl::unexpected(r.error());
  out.transfer_syntax = out.data.text(kTransferSyntax);
  const std::string& uid = out.transfer_syntax;
  Syntax syntax;
  syntax.is_explicit = uid != "1.2.840.10008.1.2" && uid != "1.2.840.113619.5.2";
  syntax.big_endian = uid == "1.2.840.10008.1.2.2";
  if (uid == "1.2.840.10008.1.2.1.99") {
    out.deflated = true;
    out.deflated_start = walker.position();
    auto inflated = open_deflated(path, out.deflated_start, Deflate::raw);
    if (!inflated) return tl::unexpected(inflated.error());
    ElementReader inner(**inflated, path, 0, std::nullopt);
    if (auto r = inner.read_data(syntax, out); !r) return tl::unexpected(r.error());
    return out;
  }
  const auto found = walker.guess_syntax(syntax);
  if (!found) return tl::unexpected(found.error());
  if (auto r = walker.read_data(*found, out); !r) return tl::unexpected(r.error());
  if (uid.empty()) {
    out.transfer_syntax = found->big_endian    ? "1.2.840.10008.1.2.2"
                          : found->is_explicit ? "1.2.840.10008.1.2.1"
                                               : "1.2.840.10008.1.2";
  }
  return out;
}

}  // namespace isosplat::import::dicom
