#pragma once

#include <memory>
#include <string>

#include "native/remote/transfer.h"

namespace isosplat::remote {

/// How buckets are reached, as the programs and libraries of AWS determine it.
struct AwsSettings {
  std::string region;    ///< "us-east-1" if none is set
  std::string endpoint;  ///< https://HOST of an S3-compatible service; empty: AWS
  /// Null if there are no credentials: requests are anonymous, as public buckets allow.
  std::shared_ptr<const AwsSignature> signature;
};

/// Reads the environment (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN, AWS_REGION
/// or AWS_DEFAULT_REGION, AWS_ENDPOINT_URL_S3 or AWS_ENDPOINT_URL), then the profile AWS_PROFILE,
/// by default "default", in ~/.aws/credentials and ~/.aws/config (other names:
/// AWS_SHARED_CREDENTIALS_FILE, AWS_CONFIG_FILE). Errors: invalid_argument: the profile does not
/// exist, it gets its credentials from a program or service (SSO, roles, credential_process), or
/// credentials are incomplete or have control characters. Messages never contain credentials.
Result<AwsSettings> load_aws_settings();

}  // namespace isosplat::remote
