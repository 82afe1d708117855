#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::server {

/// Who asks an S3 service, and with which secret.
struct ObjectCredentials {
  std::string access_key_id;
  std::string secret_access_key;
  std::string session_token;  ///< of temporary credentials; else empty
};

/// Those in `file`, in the form that AWS's tools use: lines "aws_access_key_id = ...",
/// "aws_secret_access_key = ..." and perhaps "aws_session_token = ...", in a section "[default]" or
/// before any. An empty `file` means the environment: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY,
/// AWS_SESSION_TOKEN. InvalidArgument names what is missing, or says that everyone may read the
/// file; no message has a secret.
absl::StatusOr<ObjectCredentials> ReadObjectCredentials(const std::filesystem::path& file);

}  // namespace dcloc::server
