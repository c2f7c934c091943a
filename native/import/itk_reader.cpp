#include "native/import/itk_reader.h"

#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "native/import/isolated.h"

namespace isosplat {
namespace {

/// ITK's description without the source location and object address before it, on one line.
std::string one_line(std::string text) {
  if (const auto at = text.find("): "); text.starts_with("itk::ERROR") && at != text.npos) {
    text.erase(0, at + 3);
  }
  // NRRD's reader lists the functions that failed, the innermost last.
  if (const auto at = text.rfind("[nrrd] "); at != text.npos) text.erase(0, at + 7);
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  while (!text.empty() && text.front() == ' ') text.erase(0, 1);
  return text;
}

/// Calls work(), which may throw, in a child process.
template <class Work>
Result<std::string> guarded(const std::filesystem::path& path, const Work& work) {
  return run_isolated(path, [&]() -> Result<std::string> {
    const auto refused = [&](const char* why) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: cannot be read: {}: the file is damaged, or of a kind that its "
                              "reader does not know; export it again, as NRRD for example",
                              path.string(), one_line(why)));
    };
    try {
      return work();
    } catch (const itk::ExceptionObject& e) {
      return refused(e.GetDescription());
    } catch (const std::bad_alloc&) {
      return fail(Status::out_of_memory,
                  path.string() + ": its reader ran out of memory: the header may be wrong");
    } catch (const std::exception& e) {
      return refused(e.what());
    } catch (...) {
      return refused("its reader failed without a reason");
    }
  });
}

itk::ImageIOBase::Pointer make_io(ItkFormat format) {
  switch (format) {
    case ItkFormat::nrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case ItkFormat::nifti:
      return itk::NiftiImageIO::New().GetPointer();
    case ItkFormat::meta_image:
      return itk::MetaImageIO::New().GetPointer();
    case ItkFormat::vtk:
      return itk::VTKImageIO::New().GetPointer();
    case ItkFormat::dicom:
      return itk::GDCMImageIO::New().GetPointer();
  }
  return nullptr;
}

bool to_stored_type(itk::IOComponentEnum type, StoredType& out) {
  using From = itk::IOComponentEnum;
  switch (type) {
    case From::UCHAR:
      out = StoredType::u8;
      return true;
    case From::CHAR:
      out = StoredType::i8;
      return true;
    case From::USHORT:
      out = StoredType::u16;
      return true;
    case From::SHORT:
      out = StoredType::i16;
      return true;
    case From::UINT:
      out = StoredType::u32;
      return true;
    case From::INT:
      out = StoredType::i32;
      return true;
    case From::ULONG:
      out = sizeof(long) == 8 ? StoredType::u64 : StoredType::u32;
      return true;
    case From::LONG:
      out = sizeof(long) == 8 ? StoredType::i64 : StoredType::i32;
      return true;
    case From::ULONGLONG:
      out = StoredType::u64;
      return true;
    case From::LONGLONG:
      out = StoredType::i64;
      return true;
    case From::FLOAT:
      out = StoredType::f32;
      return true;
    case From::DOUBLE:
      out = StoredType::f64;
      return true;
    default:
      return false;
  }
}

ItkHeader read_header(const itk::ImageIOBase& io) {
  ItkHeader header;
  const unsigned dimensions = io.GetNumberOfDimensions();
  for (unsigned axis = 0; axis < dimensions; ++axis) {
    header.sizes.push_back(static_cast<int64_t>(io.GetDimensions(axis)));
  }
  double* const spacing[] = {&header.geometry.spacing.x, &header.geometry.spacing.y,
                             &header.geometry.spacing.z};
  double* const origin[] = {&header.geometry.origin.x, &header.geometry.origin.y,
                            &header.geometry.origin.z};
  for (unsigned axis = 0; axis < std::min(3u, dimensions); ++axis) {
    *spacing[axis] = io.GetSpacing(axis);
    *origin[axis] = io.GetOrigin(axis);
    const std::vector<double> direction = io.GetDirection(axis);
    for (size_t row = 0; row < 3; ++row) {
      header.geometry.direction[3 * row + axis] =
          row < direction.size() ? direction[row] : (row == axis ? 1.0 : 0.0);
    }
  }
  header.components = static_cast<int>(io.GetNumberOfComponents());
  header.has_known_type = to_stored_type(io.GetComponentType(), header.type);
  return header;
}

/// An ItkHeader as it comes back from the child process.
struct HeaderRecord {
  static constexpr size_t kMaxAxes = 8;
  int64_t sizes[kMaxAxes];
  uint32_t axes;
  HeaderGeometry geometry;
  StoredType type;
  bool has_known_type;
  int components;
};
static_assert(std::is_trivially_copyable_v<HeaderRecord>);

HeaderRecord to_record(const ItkHeader& header) {
  HeaderRecord record{};
  record.axes =
      static_cast<uint32_t>(std::min<size_t>(header.sizes.size(), HeaderRecord::kMaxAxes));
  std::copy_n(header.sizes.begin(), record.axes, record.sizes);
  record.geometry = header.geometry;
  record.type = header.type;
  record.has_known_type = header.has_known_type;
  record.components = header.components;
  return record;
}

ItkHeader from_record(const HeaderRecord& record) {
  ItkHeader header;
  header.sizes.assign(record.sizes, record.sizes + record.axes);
  header.geometry = record.geometry;
  header.type = record.type;
  header.has_known_type = record.has_known_type;
  header.components = record.components;
  return header;
}

itk::ImageIOBase::Pointer open_io(ItkFormat format, const std::string& file) {
  auto io = make_io(format);
  io->SetFileName(file);
  io->ReadImageInformation();
  return io;
}

}  // namespace

Result<ItkHeader> read_itk_header(ItkFormat format, const std::filesystem::path& path) {
  const std::string file = path.string();
  auto headers = read_itk_headers(format, std::span(&file, 1));
  if (!headers) return tl::unexpected(headers.error());
  return std::move(headers->front());
}

Result<std::vector<ItkHeader>> read_itk_headers(ItkFormat format,
                                                std::span<const std::string> files) {
  std::vector<HeaderRecord> records(files.size());
  auto shared = SharedBytes::allocate(records.size() * sizeof(HeaderRecord));
  if (!shared) return tl::unexpected(shared.error());
  std::memset(shared->bytes().data(), 0xff, shared->bytes().size());  // "not read yet"
  auto done = guarded(files.front(), [&]() -> Result<std::string> {
    for (size_t i = 0; i < files.size(); ++i) {
      const HeaderRecord record = to_record(read_header(*open_io(format, files[i])));
      std::memcpy(shared->bytes().data() + i * sizeof record, &record, sizeof record);
    }
    return std::string();
  });
  std::memcpy(records.data(), shared->bytes().data(), shared->bytes().size());
  std::vector<ItkHeader> headers;
  for (size_t i = 0; i < files.size(); ++i) {
    if (records[i].axes > HeaderRecord::kMaxAxes) {
      // The file that failed is this one, not the first, which the message names.
      std::string message = done ? std::string() : done.error().message;
      if (message.starts_with(files.front())) message.erase(0, files.front().size());
      return fail(done ? Status::malformed_volume : done.error().status, files[i] + message);
    }
    headers.push_back(from_record(records[i]));
  }
  if (!done) return tl::unexpected(done.error());
  return headers;
}

Result<void> read_itk_voxels(ItkFormat format, std::span<const std::string> files,
                             std::span<const ItkHeader> headers, std::span<std::byte> out) {
  auto shared = SharedBytes::allocate(out.size());
  if (!shared) return tl::unexpected(shared.error());
  auto done = guarded(files.front(), [&]() -> Result<std::string> {
    std::byte* to = shared->bytes().data();
    for (size_t i = 0; i < files.size(); ++i) {
      const auto io = open_io(format, files[i]);
      const auto axes = static_cast<unsigned>(headers[i].sizes.size());
      itk::ImageIORegion region(axes);
      for (unsigned axis = 0; axis < axes; ++axis) {
        region.SetSize(axis,
                       static_cast<itk::ImageIORegion::SizeValueType>(headers[i].sizes[axis]));
        region.SetIndex(axis, 0);
      }
      io->SetIORegion(region);
      if (static_cast<uint64_t>(io->GetImageSizeInBytes()) != itk_bytes(headers[i])) {
        return fail(Status::malformed_volume,
                    fmt::format("{}: its header and its voxels disagree about the size, or it has "
                                "changed while it was read: start again",
                                files[i]));
      }
      io->Read(to);
      to += itk_bytes(headers[i]);
    }
    return std::string();
  });
  if (!done) return tl::unexpected(done.error());
  std::copy(shared->bytes().begin(), shared->bytes().end(), out.begin());
  return {};
}

uint64_t itk_bytes(const ItkHeader& header) {
  uint64_t bytes = stored_bytes(header.type) * static_cast<uint64_t>(header.components);
  for (const int64_t size : header.sizes) {
    if (size < 0 || __builtin_mul_overflow(bytes, static_cast<uint64_t>(size), &bytes)) return 0;
  }
  return bytes;
}

Result<std::vector<DicomSeries>> list_dicom_series(const std::filesystem::path& folder) {
  // Answer: each series' id and files as zero-terminated strings, an empty one after each series.
  const auto answer = guarded(folder, [&]() -> Result<std::string> {
    auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetInputDirectory(folder.string());
    std::string text;
    for (const std::string& id : names->GetSeriesUIDs()) {
      text.append(id).push_back('\0');
      for (const std::string& file : names->GetFileNames(id)) text.append(file).push_back('\0');
      text.push_back('\0');
    }
    return text;
  });
  if (!answer) return tl::unexpected(answer.error());
  std::vector<DicomSeries> all;
  bool inside = false;
  for (size_t at = 0; at < answer->size();) {
    const std::string text(answer->c_str() + at);
    at += text.size() + 1;
    if (text.empty()) {
      inside = false;
    } else if (!inside) {
      all.push_back({text, {}});
      inside = true;
    } else {
      all.back().files.push_back(text);
    }
  }
  std::erase_if(all, [](const DicomSeries& series) { return series.files.empty(); });
  std::stable_sort(all.begin(), all.end(), [](const DicomSeries& a, const DicomSeries& b) {
    return a.files.size() > b.files.size();
  });
  return all;
}

}  // namespace isosplat
