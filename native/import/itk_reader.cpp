#include "native/import/itk_reader.h"

#include <fmt/format.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <cstring>
#include <regex>
#include <type_traits>

#include "native/import/isolated.h"

namespace isosplat {
namespace {

/// ITK's description without source locations, its objects' names and their addresses, on one line.
std::string one_line(std::string text) {
  // "itk::ERROR: NrrdImageIO(0x55d2f0a41e20): …", also in the middle; other texts may have a bare
  // address.
  static const std::regex kObject(R"(\w+\s*\(0x[0-9a-fA-F]+\):?\s*)");
  static const std::regex kAddress(R"(\s*\(?0x[0-9a-fA-F]{6,}\)?)");
  static const std::regex kPrefix(R"((itk::|ITK )ERROR:\s*)");
  text = std::regex_replace(text, kObject, "");
  text = std::regex_replace(text, kAddress, "");
  text = std::regex_replace(text, kPrefix, "");
  // NRRD's reader lists the functions that failed, the innermost last.
  if (const auto at = text.rfind("[nrrd] "); at != text.npos) text.erase(0, at + 7);
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  while (!text.empty() && text.front() == ' ') text.erase(0, 1);
  return text;
}

/// What reading a header may take, the library's own needs included.
constexpr uint64_t kHeaderMemory = uint64_t{256} << 20;

/// Calls work(), which may throw, in a child process.
template <class Work>
Result<std::string> guarded(const std::filesystem::path& path, uint64_t memory_bytes,
                            const Work& work) {
  return run_isolated(path, memory_bytes, [&]() -> Result<std::string> {
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
                  path.string() +
                      ": its reader ran out of memory: allow more with --memory, or "
                      "correct its header");
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
  auto shared = SharedBytes::allocate(sizeof(HeaderRecord));
  if (!shared) return tl::unexpected(shared.error());
  const auto done = guarded(path, kHeaderMemory, [&]() -> Result<std::string> {
    const HeaderRecord record = to_record(read_header(*open_io(format, file)));
    std::memcpy(shared->bytes().data(), &record, sizeof record);
    return std::string();
  });
  if (!done) return tl::unexpected(done.error());
  HeaderRecord record;
  std::memcpy(&record, shared->bytes().data(), sizeof record);
  return from_record(record);
}

Result<void> read_itk_voxels(ItkFormat format, const std::string& file, const ItkHeader& header,
                             uint64_t memory_bytes, std::span<std::byte> out) {
  auto shared = SharedBytes::allocate(out.size());
  if (!shared) return tl::unexpected(shared.error());
  const auto done = guarded(file, memory_bytes, [&]() -> Result<std::string> {
    const auto io = open_io(format, file);
    const auto axes = static_cast<unsigned>(header.sizes.size());
    itk::ImageIORegion region(axes);
    for (unsigned axis = 0; axis < axes; ++axis) {
      region.SetSize(axis, static_cast<itk::ImageIORegion::SizeValueType>(header.sizes[axis]));
      region.SetIndex(axis, 0);
    }
    io->SetIORegion(region);
    if (static_cast<uint64_t>(io->GetImageSizeInBytes()) != itk_bytes(header)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: its header and its voxels disagree about the size, or it has "
                              "changed while it was read: start again",
                              file));
    }
    io->Read(shared->bytes().data());
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

}  // namespace isosplat
