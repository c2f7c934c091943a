#include "shared/import/voxels/data_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/access_points.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxFiles = 1'000'000;
constexpr size_t kMaxListBytes = 64 << 20;

/// "%03d" → 3; nothing for any other conversion.
std::optional<int64_t> width_of(std::string_view conversion) {
  if (conversion.size() < 2 || conversion.front() != '%' || conversion.back() != 'd') return {};
  conversion = conversion.substr(1, conversion.size() - 2);
  if (conversion.empty()) return 0;
  const auto width = whole_number(conversion);
  return width && *width >= 0 && *width <= 32 ? width : std::nullopt;
}

std::vector<std::string> listed_names(const std::filesystem::path& header) {
  const auto text = read_beginning(header, kMaxListBytes);
  if (!text) return {};
  std::vector<std::string> names;
  std::string_view rest = *text;
  bool in_list = false;
  while (!rest.empty() && names.size() < kMaxFiles) {
    auto line = pop_line(rest);
    if (!line) line = std::exchange(rest, {});
    const std::string_view name = trimmed(*line);
    if (in_list && !name.empty()) names.emplace_back(name);
    const std::string lower = lower_case(name);
    const size_t value = lower.find_first_of(":=");
    if (value != lower.npos && (lower.starts_with("data file") || lower.starts_with("datafile") ||
                                lower.starts_with("elementdatafile"))) {
      in_list = true;
    }
  }
  return names;
}

std::vector<std::string> numbered_names(std::string_view value) {
  const auto parts = words(value);
  if (parts.size() < 3) return {};
  const std::string_view pattern = parts[0];
  const size_t begin = pattern.find('%'), end = pattern.find('d', begin);
  const auto first = whole_number(parts[1]), last = whole_number(parts[2]);
  const auto step = parts.size() > 3 ? whole_number(parts[3]) : 1;
  if (end == pattern.npos || !first || !last || !step || *step == 0) return {};
  const auto width = width_of(pattern.substr(begin, end + 1 - begin));
  if (!width) return {};
  std::vector<std::string> names;
  for (int64_t i = *first; (*step > 0 ? i <= *last : i >= *last) && names.size() < kMaxFiles;) {
    names.push_back(
        fmt::format("{}{:0{}}{}", pattern.substr(0, begin), i, *width, pattern.substr(end + 1)));
    if (__builtin_add_overflow(i, *step, &i)) break;
  }
  return names;
}

struct Part {
  std::filesystem::path path;
  uint64_t start = 0;  ///< in its file
  uint64_t bytes = 0;  ///< present in the file; the rest of bytes_each reads as zeros
};

class JoinedReader : public ByteReader {
 public:
  JoinedReader(std::vector<Part> parts, uint64_t bytes_each, bool deflated)
      : parts_(std::move(parts)), bytes_each_(bytes_each), deflated_(deflated) {}

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    while (!out.empty()) {
      const uint64_t index = offset / bytes_each_, inside = offset % bytes_each_;
      if (index >= parts_.size()) {
        return fail(Status::truncated, parts_.front().path.string() +
                                           ": the header names fewer data files than expected");
      }
      const Part& part = parts_[static_cast<size_t>(index)];
      const auto some = static_cast<size_t>(std::min<uint64_t>(out.size(), bytes_each_ - inside));
      const auto there =
          static_cast<size_t>(std::min<uint64_t>(some, part.bytes - std::min(part.bytes, inside)));
      if (there > 0) {
        if (auto opened = open(static_cast<size_t>(index)); !opened) return opened;
        if (auto r = current_->read(part.start + inside, out.first(there)); !r) return r;
      }
      std::fill_n(out.data() + there, some - there, std::byte{0});
      out = out.subspan(some);
      offset += some;
    }
    return {};
  }

  Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) override {
    const uint64_t size = size_limit();
    return std::min(max_count, size - std::min(size, offset));
  }

  bool is_random_access() const override { return !deflated_; }
  uint64_t size_limit() const override { return parts_.size() * bytes_each_; }
  uint64_t available_bytes() override { return size_limit(); }
  uint64_t resident_bytes() const override {
    return deflated_ ? AccessPoints::max_bytes(bytes_each_) : 0;
  }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Part& part : parts_) files.push_back(part.path);
    return files;
  }

 private:
  Result<void> open(size_t index) {
    if (current_ && current_index_ == index) return {};
    auto reader = deflated_ ? open_deflated(parts_[index].path) : open_plain(parts_[index].path);
    if (!reader) return tl::unexpected(reader.error());
    current_ = std::move(*reader);
    current_index_ = index;
    return {};
  }

  std::vector<Part> parts_;
  uint64_t bytes_each_;
  bool deflated_;
  std::unique_ptr<ByteReader> current_;
  size_t current_index_ = 0;
};

/// Finds the voxels of one file. Errors: truncated, malformed_volume, io_error.
Result<Part> find_part(const std::filesystem::path& path, const DataFiles& files,
                       Allowances allowed, std::vector<std::string>& notes) {
  Part part{path, files.skip > 0 ? static_cast<uint64_t>(files.skip) : 0, files.bytes_each};
  uint64_t size = 0;
  if (files.deflated) {
    auto reader = open_deflated(path);
    if (!reader) return tl::unexpected(reader.error());
    size = (*reader)->available_bytes();
  } else {
    const auto found = size_of_file(path);
    if (!found) return tl::unexpected(found.error());
    size = *found;
  }
  if (files.skip < 0) {
    const auto start = offset_before_end(path, size, 0, files.bytes_each);
    if (!start) return tl::unexpected(start.error());
    part.start = *start;
  }
  const uint64_t found = size - std::min(size, part.start);
  const auto numbers = fmt::format("{}: expected {} bytes of voxels, found {}", path.string(),
                                   files.bytes_each, found);
  if (found < files.bytes_each) {
    if (!allowed.has(Allowance::truncated)) {
      return fail(Status::truncated, fmt::format("{}: the file is incomplete, or the header is "
                                                 "wrong; copy the file again, or read it with {}",
                                                 numbers, flag_of(Allowance::truncated)));
    }
    part.bytes = found - found % files.voxel_bytes;
    notes.push_back(numbers + ": the missing voxels have no value");
  } else if (found > files.bytes_each) {
    if (!allowed.has(Allowance::surplus)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: the header's sizes or type do not fit the file; correct them, "
                              "or ignore the surplus with {}",
                              numbers, flag_of(Allowance::surplus)));
    }
    notes.push_back(numbers + ": the surplus is ignored");
  }
  return part;
}

}  // namespace

bool is_list_of_files(std::string_view value) {
  const auto parts = words(value);
  return !parts.empty() && lower_case(parts[0]) == "list";
}

Result<uint64_t> offset_before_end(const std::filesystem::path& path, uint64_t file_bytes,
                                   uint64_t begin, uint64_t bytes) {
  const uint64_t found = file_bytes - std::min(file_bytes, begin);
  if (found >= bytes) return file_bytes - bytes;
  return fail(Status::truncated,
              fmt::format("{}: expected {} bytes of voxels at the end of the file, found {}: the "
                          "file is incomplete, or its header is wrong; copy or download it again",
                          path.string(), bytes, found));
}

std::vector<std::filesystem::path> named_data_files(const std::filesystem::path& header,
                                                    std::string_view value) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name :
       is_list_of_files(value) ? listed_names(header) : numbered_names(value)) {
    const std::filesystem::path file(name);
    files.push_back(file.is_relative() ? header.parent_path() / file : file);
  }
  return files;
}

bool divides_axes(size_t files, std::span<const int64_t> sizes) {
  uint64_t count = 1;
  for (size_t axis = sizes.size(); axis > 0 && count <= files; --axis) {
    if (count == files) return true;
    if (__builtin_mul_overflow(count, static_cast<uint64_t>(sizes[axis - 1]), &count)) return false;
  }
  return count == files;
}

Result<JoinedFiles> open_data_files(const std::filesystem::path& header, DataFiles files,
                                    Allowances allowed) {
  JoinedFiles joined;
  std::vector<Part> parts;
  std::vector<std::filesystem::path> absent;
  std::vector<std::string> odd;
  for (const std::filesystem::path& path : files.paths) {
    const uint64_t begin = parts.size() * files.bytes_each;
    Part part{path, 0, 0};
    if (input_kind(path) != InputKind::none) {
      auto found = find_part(path, files, allowed, odd);
      if (!found) return tl::unexpected(found.error());
      part = std::move(*found);
    } else {
      absent.push_back(path);
    }
    if (part.bytes < files.bytes_each) {
      joined.missing.push_back({begin + part.bytes, begin + files.bytes_each});
    }
    parts.push_back(std::move(part));
  }
  if (!absent.empty()) {
    const auto text =
        fmt::format("{}: {} of the {} data files in its header are missing, the first is {}",
                    header.string(), absent.size(), parts.size(), absent.front().string());
    if (!allowed.has(Allowance::gaps) || absent.size() == parts.size()) {
      return fail(Status::io_error, fmt::format("{}: add the files, or correct the header{}", text,
                                                absent.size() == parts.size()
                                                    ? ""
                                                    : fmt::format(", or read without them with {}",
                                                                  flag_of(Allowance::gaps))));
    }
    joined.notes.push_back(text + ": their voxels have no value");
  }
  if (!odd.empty()) joined.notes.push_back(odd.front());
  if (odd.size() > 1) {
    joined.notes.push_back(fmt::format("{} data files have an unexpected size", odd.size()));
  }
  joined.reader =
      std::make_unique<JoinedReader>(std::move(parts), files.bytes_each, files.deflated);
  return joined;
}

}  // namespace isosplat::import
