#include "shared/import/dicom/segment_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <memory>

#include "shared/import/dicom/check_images.h"
#include "shared/import/dicom/copies.h"
#include "shared/import/dicom/segment_order.h"
#include "shared/import/dicom/segment_pixels.h"
#include "shared/import/dicom/step_frames.h"
#include "shared/import/dicom/values.h"
#include "shared/import/text/header_text.h"
#include "shared/import/text/name_list.h"
#include "shared/import/volume/volume_name.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/slice_range.h"

namespace isosplat::import::dicom {
namespace {

/// Real segmentations have hundreds of segments. A scene has as many layers at most.
constexpr size_t kMaxSegments = 4096;

/// Number of names that a message lists.
constexpr size_t kMaxNames = 8;

SegmentDescription description_of(const Segmentation::Segment& segment) {
  SegmentDescription out{segment.number, segment.label, segment.meaning, {}};
  const std::vector<double>& lab = segment.cie_lab;
  const auto is_component = [](double v) { return v >= 0 && v <= 65535; };
  if (lab.size() == 3 && std::all_of(lab.begin(), lab.end(), is_component)) {
    out.cie_lab = {lab[0] * 100 / 65535, lab[1] * 255 / 65535 - 128, lab[2] * 255 / 65535 - 128};
  }
  return out;
}

std::string name_of(const SegmentDescription& segment) {
  return segment.label.empty() ? std::to_string(segment.number)
                               : fmt::format("{} (\"{}\")", segment.number, segment.label);
}

std::string names_of(const std::vector<SegmentDescription>& segments) {
  std::vector<std::string> names;
  for (const SegmentDescription& segment : segments) names.push_back(name_of(segment));
  return name_list(names, kMaxNames);
}

/// Keeps the segments that the option chooses: by number, or else by label; all if it is empty.
std::vector<SegmentDescription> chosen(const std::vector<SegmentDescription>& segments,
                                       const std::string& wanted) {
  if (wanted.empty()) return segments;
  int number = -1;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  const bool is_number = error == std::errc{} && end == wanted.data() + wanted.size();
  std::vector<SegmentDescription> found;
  for (const SegmentDescription& each : segments) {
    if (is_number && each.number == number) found.push_back(each);
  }
  for (const SegmentDescription& each : segments) {
    if (found.empty() && lower_case(each.label) == lower_case(wanted)) found.push_back(each);
  }
  return found;
}

tl::unexpected<Error> no_such_segment(const std::vector<SegmentDescription>& segments,
                                      const std::string& wanted,
                                      const std::filesystem::path& path) {
  return fail(Status::invalid_argument,
              fmt::format("{}: expected one of the segments {} for --segment, found \"{}\"",
                          path.string(), names_of(segments), wanted));
}

/// The data that all maps of a file use.
struct SharedPixels {
  SegmentPixels pixels;
  std::vector<uint16_t> numbers;  ///< of the segments
  std::vector<uint16_t> groups;   ///< the map of each segment
};

/// The segments of a group as a volume of their numbers.
class SegmentSource : public VolumeSource {
 public:
  SegmentSource(VolumeHeader header, std::shared_ptr<const SharedPixels> shared, uint16_t group,
                bool reverse)
      : header_(std::move(header)), shared_(std::move(shared)), group_(group), reverse_(reverse) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    if (auto inside = check_slices(header_, first, count, out.size()); !inside) return inside;
    std::fill(out.begin(), out.end(), std::byte{0});
    const size_t row = static_cast<size_t>(header_.grid.voxels.x) * sizeof(uint16_t);
    const size_t bytes = row * static_cast<size_t>(header_.grid.voxels.y);
    const auto begin = static_cast<size_t>(first);
    auto read = shared_->pixels.read(
        begin, static_cast<size_t>(count),
        [&](uint16_t segment) { return shared_->groups[segment] == group_; },
        [&](size_t slice, uint16_t segment, std::span<const uint8_t> inside) -> Result<void> {
          const auto to = out.subspan((slice - begin) * bytes, bytes);
          const uint16_t number = shared_->numbers[segment];
          for (size_t i = 0; i < inside.size(); ++i) {
            if (inside[i]) std::memcpy(to.data() + i * sizeof number, &number, sizeof number);
          }
          return {};
        });
    for (size_t z = 0; reverse_ && z < out.size(); z += bytes) {
      reverse_rows(out.subspan(z, bytes), row);
    }
    return read;
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Image& image : shared_->pixels.images) files.emplace_back(image.file);
    return files;
  }

 private:
  VolumeHeader header_;
  std::shared_ptr<const SharedPixels> shared_;
  uint16_t group_;
  bool reverse_;
};

/// The frames of a segment.
struct Segment {
  SegmentDescription description;
  std::vector<uint32_t> frames;
};

/// Makes the maps of one file, or of one concatenation of files.
class SegmentMapper {
 public:
  /// `known`: receives the descriptions of all segments.
  SegmentMapper(const Collection& collection, const std::filesystem::path& path,
                const ImportOptions& options, std::vector<std::string>& notes,
                std::vector<SegmentDescription>& known)
      : collection_(collection), path_(path), options_(options), notes_(notes), known_(known) {}

  /// `frames`: of this file. Empty if it has no segment that is wanted.
  Result<std::vector<SegmentMap>> map(const std::vector<uint32_t>& frames) {
    if (auto r = check_images(collection_, frames, path_, options_, notes_); !r) {
      return tl::unexpected(r.error());
    }
    const OrderInput in{collection_, path_, options_, notes_};
    const auto all = without_copies(in, frames);
    if (!all) return tl::unexpected(all.error());
    if (!in.frame_of(all->front()).is_placed) {
      return in.malformed(
          "expected a position of each frame for --labels, found none: choose one segment with "
          "--segment, and build it without --labels");
    }
    auto segments = segments_of(*all);
    if (!segments) return tl::unexpected(segments.error());
    if (segments->empty()) return std::vector<SegmentMap>{};
    const auto lattice = segment_lattice(in, *all);
    if (!lattice) return tl::unexpected(lattice.error());
    auto shared = std::make_shared<SharedPixels>();
    if (auto r = place(in, *segments, *lattice, *shared); !r) return tl::unexpected(r.error());
    auto groups =
        groups_without_overlap(shared->pixels, segments->size(), path_, options_.memory_bytes);
    if (!groups) return tl::unexpected(groups.error());
    shared->groups = std::move(*groups);
    return maps(*segments, *lattice, std::move(shared));
  }

 private:
  const Image& image_of(uint32_t frame) const {
    return collection_.images[collection_.frames[frame].image];
  }

  /// The chosen segments that have frames, by number.
  Result<std::vector<Segment>> segments_of(const std::vector<uint32_t>& frames) const {
    std::map<int, Segment> by_number;
    for (const uint32_t frame : frames) {
      for (const Segmentation::Segment& each : image_of(frame).segmentation.segments) {
        Segment& segment = by_number[each.number];
        if (segment.description.number == 0) segment.description = description_of(each);
        if (by_number.size() > kMaxSegments) break;
      }
      const int number = collection_.frames[frame].segment;
      by_number[number].description.number = number;
      by_number[number].frames.push_back(frame);
      if (by_number.size() > kMaxSegments) {
        return fail(Status::unsupported_format,
                    fmt::format("{}: expected at most {} segments, found more: choose one with "
                                "--segment",
                                path_.string(), kMaxSegments));
      }
    }
    if (by_number.contains(0)) {
      if (by_number.size() > 1) {
        return contradiction(path_, "a frame does not state its segment (Segment Identification)");
      }
      by_number[1] = std::move(by_number[0]);
      by_number.erase(0);
      by_number[1].description.number = 1;
    }
    std::vector<SegmentDescription> described, empty;
    for (const auto& [number, segment] : by_number) described.push_back(segment.description);
    known_.insert(known_.end(), described.begin(), described.end());
    std::vector<Segment> segments;
    for (const SegmentDescription& each : chosen(described, options_.segment)) {
      Segment& segment = by_number[each.number];
      if (segment.frames.empty()) {
        empty.push_back(each);
      } else {
        segments.push_back(std::move(segment));
      }
    }
    if (!empty.empty()) {
      notes_.push_back(fmt::format("{} of the segments have no frames, so they are empty: {}",
                                   empty.size(), names_of(empty)));
    }
    return segments;
  }

  /// Finds the slice of each frame.
  Result<void> place(const OrderInput& in, const std::vector<Segment>& segments,
                     const SegmentLattice& lattice, SharedPixels& out) const {
    std::map<uint32_t, uint32_t> images;  // index in pixels.images, by index in the collection
    std::vector<uint32_t> used;
    SegmentPixels& pixels = out.pixels;
    pixels.slices.resize(static_cast<size_t>(lattice.steps) + 1);
    for (size_t i = 0; i < segments.size(); ++i) {
      const auto step = frames_of_step(in, in_order(in, segments[i].frames, lattice.normal), true);
      if (!step) return tl::unexpected(step.error());
      for (const uint32_t index : *step) {
        const Frame& frame = collection_.frames[index];
        const auto [at, is_new] =
            images.try_emplace(frame.image, static_cast<uint32_t>(images.size()));
        if (is_new) pixels.images.push_back(collection_.images[frame.image]);
        pixels.slices[lattice.slice_of(frame)].push_back(
            {at->second, frame.index, static_cast<uint16_t>(i)});
        used.push_back(index);
      }
      out.numbers.push_back(static_cast<uint16_t>(segments[i].description.number));
    }
    const Segmentation& first = pixels.images.front().segmentation;
    if (first.kind == Segmentation::Kind::fractional) {
      pixels.threshold = std::max(first.max_fraction, 1) / 2.0;
      notes_.push_back(
          fmt::format("the segments are fractions: voxels from {} on belong to them, half of the "
                      "Maximum Fractional Value",
                      pixels.threshold));
    }
    pixels.type = find_values(collection_, used).type;
    pixels.fill_missing = options_.allowed.has(Allowance::truncated);
    pixels.memory_bytes = options_.memory_bytes;
    return {};
  }

  Result<std::vector<SegmentMap>> maps(const std::vector<Segment>& segments,
                                       const SegmentLattice& lattice,
                                       std::shared_ptr<const SharedPixels> shared) const {
    HeaderGeometry geometry = lattice.geometry;
    if (options_.spacing) geometry.spacing = *options_.spacing;
    const Image& image = shared->pixels.images.front();
    auto orientation = orient(
        {image.columns, image.rows, static_cast<int64_t>(shared->pixels.slices.size())}, geometry);
    if (!orientation) {
      return fail(orientation.error().status, path_.string() + ": " + orientation.error().message);
    }
    notes_.insert(notes_.end(), orientation->notes.begin(), orientation->notes.end());
    std::vector<SegmentMap> maps(1u +
                                 *std::max_element(shared->groups.begin(), shared->groups.end()));
    const VolumeHeader header{
        orientation->grid,        VoxelType::u16, "DICOM", volume_name(path_), 1, 0,
        frame_of_reference(image)};
    for (size_t group = 0; group < maps.size(); ++group) {
      maps[group].volume.source = std::make_unique<SegmentSource>(
          header, shared, static_cast<uint16_t>(group), orientation->reverse_rows);
    }
    for (size_t i = 0; i < segments.size(); ++i) {
      maps[shared->groups[i]].segments.push_back(segments[i].description);
    }
    return maps;
  }

  const Collection& collection_;
  const std::filesystem::path& path_;
  const ImportOptions& options_;
  std::vector<std::string>& notes_;
  std::vector<SegmentDescription>& known_;
};

}  // namespace

Result<std::vector<SegmentMap>> map_segments(const Collection& collection, const Stack& stack,
                                             const std::filesystem::path& path,
                                             const ImportOptions& options,
                                             std::vector<std::string> notes) {
  std::map<std::string, std::vector<uint32_t>> files;
  for (const uint32_t frame : stack.frames) {
    const Image& image = collection.images[collection.frames[frame].image];
    const std::string& uid = image.concatenation.uid;
    files[uid.empty() ? "file " + image.file : "concatenation " + uid].push_back(frame);
  }
  std::vector<SegmentMap> maps;
  std::vector<SegmentDescription> known;
  for (const auto& [name, frames] : files) {
    auto some = SegmentMapper(collection, path, options, notes, known).map(frames);
    if (!some) return tl::unexpected(some.error());
    std::move(some->begin(), some->end(), std::back_inserter(maps));
  }
  if (maps.empty() && chosen(known, options.segment).empty()) {
    return no_such_segment(known, options.segment, path);
  }
  if (maps.empty()) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected segments with frames, found none", path.string()));
  }
  maps.front().volume.notes = std::move(notes);
  return maps;
}

Result<SegmentMap> describe_label_map(const Collection& collection, const Stack& stack,
                                      const std::filesystem::path& path,
                                      const ImportOptions& options) {
  SegmentMap map;
  const Segmentation& first =
      collection.images[collection.frames[stack.frames.front()].image].segmentation;
  map.background = static_cast<int64_t>(std::clamp(first.background, -65536.0, 65535.0));
  for (const Segmentation::Segment& each : first.segments) {
    map.segments.push_back(description_of(each));
  }
  if (options.segment.empty()) return map;
  const auto wanted = chosen(map.segments, options.segment);
  if (wanted.empty()) return no_such_segment(map.segments, options.segment, path);
  map.only = wanted.front().number;
  return map;
}

}  // namespace isosplat::import::dicom
