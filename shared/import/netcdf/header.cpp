#include "shared/import/netcdf/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/text/header_text.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import::netcdf {
namespace {

constexpr uint64_t kMaxHeader = uint64_t{64} << 20;
/// Attributes with more numbers or characters are skipped.
constexpr uint64_t kMaxNumbers = 1024, kMaxText = 4096;
constexpr uint32_t kDimensions = 10, kVariables = 11, kAttributes = 12;

/// NC_CHAR has no numbers. Types from 7 on are those of CDF-5.
std::optional<VoxelType> number_type_of(uint32_t type) {
  constexpr VoxelType kTypes[] = {VoxelType::i8,  VoxelType::u8,  VoxelType::i16, VoxelType::i32,
                                  VoxelType::f32, VoxelType::f64, VoxelType::u8,  VoxelType::u16,
                                  VoxelType::u32, VoxelType::i64, VoxelType::u64};
  if (type < 1 || type > std::size(kTypes) || type == 2) return std::nullopt;
  return kTypes[type - 1];
}

uint64_t padded(uint64_t bytes) {
  return (bytes + 3) / 4 * 4;
}

class Parser {
 public:
  Parser(const std::filesystem::path& path, std::span<const std::byte> bytes, uint64_t file_bytes)
      : path_(path), bytes_(bytes), file_bytes_(file_bytes) {}

  /// Whether the bytes ended before the header.
  bool needs_more() const { return needs_more_; }

  Result<Header> parse() {
    at_ = 3;
    version_ = static_cast<uint32_t>(bytes_[at_++]);
    const uint64_t records = count();
    const bool is_streamed = records == (version_ == 5 ? ~uint64_t{0} : ~uint32_t{0});
    read_dimensions();
    attributes();
    read_variables();
    if (needs_more_) return fail(Status::truncated, "");
    if (!problem_.empty()) return malformed(problem_);
    if (auto placed = place_records(records, is_streamed); !placed) {
      return tl::unexpected(placed.error());
    }
    return std::move(header_);
  }

 private:
  tl::unexpected<Error> malformed(const std::string& what) const {
    return fail(Status::malformed_volume,
                fmt::format("{}: {}: the file is damaged", path_.string(), what));
  }
  void problem(std::string what) {
    if (problem_.empty()) problem_ = std::move(what);
  }
  bool ends() const { return needs_more_ || !problem_.empty(); }

  std::span<const std::byte> take(uint64_t bytes) {
    if (ends() || bytes > bytes_.size() - at_) {
      needs_more_ = needs_more_ || problem_.empty();
      return {};
    }
    const auto taken = bytes_.subspan(at_, static_cast<size_t>(bytes));
    at_ += static_cast<size_t>(bytes);
    return taken;
  }

  uint64_t number(size_t bytes) {
    uint64_t value = 0;
    for (const std::byte byte : take(bytes)) value = value << 8 | static_cast<uint64_t>(byte);
    return value;
  }
  uint32_t word() { return static_cast<uint32_t>(number(4)); }
  /// NON_NEG: a size or a number of elements.
  uint64_t count() { return number(version_ == 5 ? 8 : 4); }

  std::string text(uint64_t bytes) {
    const auto taken = take(bytes);
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }

  std::string name() {
    const uint64_t bytes = count();
    std::string found = text(bytes);
    take(padded(bytes) - bytes);
    return found;
  }

  /// The number of elements of a list with this tag. Each has at least `least` bytes.
  uint64_t list(uint32_t tag, uint64_t least) {
    const uint32_t found = word();
    const uint64_t elements = count();
    if (ends() || (found == 0 && elements == 0)) return 0;
    if (found != tag) problem(fmt::format("expected a list with the tag {}, found {}", tag, found));
    if (elements > file_bytes_ / least) {
      problem(fmt::format("expected a list that fits the file, found {} elements", elements));
    }
    return ends() ? 0 : elements;
  }

  void read_dimensions() {
    for (uint64_t left = list(kDimensions, 8); left > 0 && !ends(); --left) {
      Dimension dimension;
      dimension.name = name();
      dimension.size = count();
      dimension.is_record = dimension.size == 0;
      header_.dimensions.push_back(std::move(dimension));
    }
  }

  std::vector<Attribute> attributes() {
    std::vector<Attribute> found;
    for (uint64_t left = list(kAttributes, 12); left > 0 && !ends(); --left) {
      Attribute attribute{name()};
      const uint32_t type = word();
      const uint64_t elements = count();
      attribute.type = number_type_of(type);
      if (!attribute.type && type != 2) problem(fmt::format("expected a type, found {}", type));
      const size_t each = attribute.type ? voxel_bytes(*attribute.type) : 1;
      if (elements > file_bytes_) {
        problem(
            fmt::format("expected an attribute that fits the file, found {} elements", elements));
      }
      if (ends()) break;
      const auto values = take(elements * each);
      take(padded(elements * each) - elements * each);
      if (!attribute.type && elements <= kMaxText) {
        attribute.text = {reinterpret_cast<const char*>(values.data()), values.size()};
        attribute.text.resize(std::min(attribute.text.find('\0'), attribute.text.size()));
        attribute.text = trimmed(attribute.text);
      } else if (attribute.type && elements <= kMaxNumbers) {
        for (size_t i = 0; i + each <= values.size(); i += each) {
          attribute.numbers.push_back(stored_number({.type = *attribute.type, .big_endian = true},
                                                    values.subspan(i, each)));
        }
      }
      found.push_back(std::move(attribute));
    }
    return found;
  }

  void read_variables() {
    for (uint64_t left = list(kVariables, 24); left > 0 && !ends(); --left) {
      Variable variable;
      variable.name = name();
      const uint64_t axes = count();
      for (uint64_t i = 0; i < axes && !ends(); ++i) {
        const uint64_t dimension = count();
        if (ends()) break;
        if (dimension >= header_.dimensions.size()) {
          problem(fmt::format("expected one of {} dimensions, found number {}",
                              header_.dimensions.size(), dimension));
        } else if (i > 0 && header_.dimensions[static_cast<size_t>(dimension)].is_record) {
          problem("expected records along the first axis, found them along another");
        } else {
          variable.dimensions.push_back(static_cast<size_t>(dimension));
        }
      }
      variable.attributes = attributes();
      const uint32_t type = word();
      variable.type = number_type_of(type);
      if (!ends() && !variable.type && type != 2) {
        problem(fmt::format("expected a type, found {}", type));
      }
      count();  // vsize: may have overflowed, and follows from type and dimensions
      variable.begin = number(version_ == 1 ? 4 : 8);
      header_.variables.push_back(std::move(variable));
    }
  }

  /// The bytes of a variable, or of one of its records, without padding. Nothing if they overflow.
  std::optional<uint64_t> bytes_of(const Variable& variable) const {
    uint64_t bytes = variable.type ? voxel_bytes(*variable.type) : 1;
    for (const size_t i : variable.dimensions) {
      const Dimension& dimension = header_.dimensions[i];
      if (!dimension.is_record && __builtin_mul_overflow(bytes, dimension.size, &bytes)) {
        return std::nullopt;
      }
    }
    return bytes <= ~uint64_t{0} - 3 ? std::optional(bytes) : std::nullopt;
  }

  Result<void> place_records(uint64_t records, bool is_streamed) {
    std::vector<const Variable*> recorded;
    for (const Variable& variable : header_.variables) {
      if (header_.has_records(variable)) recorded.push_back(&variable);
    }
    uint64_t first = ~uint64_t{0};
    for (const Variable* variable : recorded) {
      const auto bytes = bytes_of(*variable);
      // Records of a file's only variable are not padded.
      const uint64_t own = bytes ? (recorded.size() == 1 ? *bytes : padded(*bytes)) : 0;
      if (!bytes || __builtin_add_overflow(header_.record_bytes, own, &header_.record_bytes)) {
        return malformed(fmt::format("expected records that fit a file, found those of {}",
                                     printable(variable->name)));
      }
      first = std::min(first, variable->begin);
    }
    // A file that is still written does not state the number of its records.
    if (is_streamed) {
      records = header_.record_bytes == 0 || first > file_bytes_
                    ? 0
                    : (file_bytes_ - first) / header_.record_bytes;
    }
    for (Dimension& dimension : header_.dimensions) {
      if (dimension.is_record) dimension.size = records;
    }
    return {};
  }

  const std::filesystem::path& path_;
  std::span<const std::byte> bytes_;
  uint64_t file_bytes_;
  size_t at_ = 0;
  uint32_t version_ = 1;
  bool needs_more_ = false;
  std::string problem_;
  Header header_;
};

}  // namespace

const Attribute* Variable::find(std::string_view sought) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(),
                                  [&](const Attribute& each) { return each.name == sought; });
  return found == attributes.end() ? nullptr : &*found;
}

std::optional<std::vector<double>> Variable::numbers(std::string_view sought) const {
  const Attribute* found = find(sought);
  if (!found || found->numbers.empty()) return std::nullopt;
  return found->numbers;
}

std::optional<VoxelType> Variable::number_type(std::string_view sought) const {
  const Attribute* found = find(sought);
  return found && !found->numbers.empty() ? found->type : std::nullopt;
}

std::string Variable::text(std::string_view sought) const {
  const Attribute* found = find(sought);
  return found ? found->text : std::string();
}

const Variable* Header::find(std::string_view name) const {
  const auto found = std::find_if(variables.begin(), variables.end(),
                                  [&](const Variable& each) { return each.name == name; });
  return found == variables.end() ? nullptr : &*found;
}

std::vector<uint64_t> Header::sizes(const Variable& variable) const {
  std::vector<uint64_t> sizes;
  for (const size_t i : variable.dimensions) sizes.push_back(dimensions[i].size);
  return sizes;
}

bool Header::has_records(const Variable& variable) const {
  return !variable.dimensions.empty() && dimensions[variable.dimensions.front()].is_record;
}

Result<Header> read_header(const std::filesystem::path& path) {
  const auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  const uint64_t file_bytes = (*file)->size_limit();
  std::vector<std::byte> bytes;
  for (uint64_t most = 64 * 1024;; most *= 4) {
    const auto had = bytes.size();
    bytes.resize(static_cast<size_t>(std::min(most, file_bytes)));
    auto read = (*file)->read(had, std::span(bytes).subspan(had));
    if (!read) return tl::unexpected(read.error());
    Parser parser(path, bytes, file_bytes);
    auto header = bytes.size() < 8 ? fail(Status::truncated, "") : parser.parse();
    if (header || (bytes.size() >= 8 && !parser.needs_more())) return header;
    if (bytes.size() == file_bytes) {
      return fail(Status::truncated,
                  fmt::format("{}: expected a whole header, found its end after {} bytes: the file "
                              "is incomplete",
                              path.string(), file_bytes));
    }
    if (most >= kMaxHeader) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected a header of at most {} MiB, found a larger one: save "
                              "the variable in a file of its own",
                              path.string(), kMaxHeader >> 20));
    }
  }
}

}  // namespace isosplat::import::netcdf
