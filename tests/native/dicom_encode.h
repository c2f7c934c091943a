#pragma once

#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>

#include <filesystem>

namespace isosplat::test {

/// Rewrites a file's pixels in another transfer syntax, with GDCM's encoders.
inline bool encode(const std::filesystem::path& path, gdcm::TransferSyntax::TSType type) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) return false;
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(type);
  change.SetInput(reader.GetImage());
  if (!change.Change()) return false;
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(path.c_str());
  return writer.Write();
}

}  // namespace isosplat::test
