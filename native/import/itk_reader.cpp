#include "native/import/itk_reader.h"

#include <fmt/format.h>
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <iostream>
#include <streambuf>

namespace isosplat {
namespace {

/// Drops what is written to std::cout and std::cerr while it lives: ITK and the libraries below it
/// print warnings there, and the errors that they also throw.
class Silence {
 public:
  Silence() : cout_(std::cout.rdbuf(&nothing_)), cerr_(std::cerr.rdbuf(&nothing_)) {
    itk::Object::SetGlobalWarningDisplay(false);
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
  }
  ~Silence() {
    std::cout.rdbuf(cout_);
    std::cerr.rdbuf(cerr_);
    std::cout.clear();
    std::cerr.clear();
  }
  Silence(const Silence&) = delete;

 private:
  class Nothing : public std::streambuf {
    int overflow(int c) override { return c; }
    std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
  };
  Nothing nothing_;
  std::streambuf* cout_;
  std::streambuf* cerr_;
};

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

template <class Work>
Result<void> guarded(const std::filesystem::path& path, const Work& work) {
  const auto refused = [&](const char* why) {
    return fail(Status::malformed_volume,
                fmt::format("{}: cannot be read: {}: the file is damaged, or of a kind that its "
                            "reader does not know; export it again, as NRRD for example",
                            path.string(), one_line(why)));
  };
  try {
    const Silence silence;
    work();
    return {};
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

}  // namespace

struct ItkReader::State {
  std::filesystem::path path;
  itk::ImageIOBase::Pointer io;
  ItkHeader header;
};

ItkReader::ItkReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
ItkReader::ItkReader(ItkReader&&) noexcept = default;
ItkReader::~ItkReader() = default;

Result<ItkReader> ItkReader::open(ItkFormat format, const std::filesystem::path& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  auto done = guarded(path, [&] {
    state->io = make_io(format);
    state->io->SetFileName(path.string());
    state->io->ReadImageInformation();
    state->header = read_header(*state->io);
  });
  if (!done) return tl::unexpected(done.error());
  return ItkReader(std::move(state));
}

const ItkHeader& ItkReader::header() const {
  return state_->header;
}

Result<void> ItkReader::read_all(std::span<std::byte> out) {
  return guarded(state_->path, [&] {
    const auto& sizes = state_->header.sizes;
    itk::ImageIORegion region(static_cast<unsigned>(sizes.size()));
    for (unsigned axis = 0; axis < sizes.size(); ++axis) {
      region.SetSize(axis, static_cast<itk::ImageIORegion::SizeValueType>(sizes[axis]));
      region.SetIndex(axis, 0);
    }
    state_->io->SetIORegion(region);
    if (static_cast<uint64_t>(state_->io->GetImageSizeInBytes()) != out.size()) {
      throw std::runtime_error("the header and the data disagree about the size");
    }
    state_->io->Read(out.data());
  });
}

Result<std::vector<DicomSeries>> list_dicom_series(const std::filesystem::path& folder) {
  std::vector<DicomSeries> all;
  auto done = guarded(folder, [&] {
    auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetInputDirectory(folder.string());
    for (const std::string& id : names->GetSeriesUIDs()) {
      all.push_back({id, names->GetFileNames(id)});
    }
  });
  if (!done) return tl::unexpected(done.error());
  std::stable_sort(all.begin(), all.end(), [](const DicomSeries& a, const DicomSeries& b) {
    return a.files.size() > b.files.size();
  });
  return all;
}

}  // namespace isosplat
