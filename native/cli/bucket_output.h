#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "native/cli/remote_flags.h"
#include "native/cli/upload_folder.h"

namespace isosplat::cli {

/// An output of a command that goes to an object of a bucket. The file is written as a whole to a
/// temporary folder first, because the header of a store, at its beginning, is written last; then
/// it is uploaded.
class BucketOutput {
 public:
  /// address: s3://BUCKET/KEY. folder: in which the temporary folder is made; empty: the system's.
  /// Errors: those of target_of(), invalid_argument if there are no credentials, io_error.
  static Result<BucketOutput> create(const std::string& address, const RemoteFlags& flags,
                                     const std::filesystem::path& folder);

  /// The path at which the command writes the file: in the temporary folder, with the name that the
  /// key ends with.
  const std::filesystem::path& file() const { return file_; }

  /// Checks that the object may be written: there is none, or it is a store of this source, or, if
  /// the output is a bundle, a bundle. Errors: invalid_argument, io_error.
  Result<void> check_replaceable(const std::string& source_path_hash) const;

  /// Uploads file(), and its thumbnail to KEY.png if there is one, with progress on stderr. Without
  /// `force`, another object than a thumbnail keeps this name, which a note says. Returns
  /// the bytes of file(). Reads the credentials again, since those of create() may have expired in
  /// the meantime. After an error, the file is kept; the message has its path and a command that
  /// uploads it. Errors: io_error, those of target_of() and remote::upload().
  Result<uint64_t> publish(bool force);

 private:
  BucketOutput() = default;
  Result<uint64_t> send(const std::filesystem::path& path, const std::string& address,
                        std::string type);
  Result<void> check_thumbnail(const std::string& address) const;
  Error kept(Error error);

  remote::RemoteOptions options_;
  std::string address_;
  std::unique_ptr<remote::HttpClient> client_;
  UploadFolder folder_;
  std::filesystem::path file_;
};

}  // namespace isosplat::cli
