#pragma once

#include "absl/status/status.h"
#include "server/objects/s3_client.h"

namespace dcloc::server {

/// What an answer of an S3 service means. OK; NotFound: there is no such object; OutOfRange: the
/// object ends before the range that was asked for; Unavailable: it may pass, so the request is to
/// be sent again; FailedPrecondition: it will not. The messages have the status and the service's
/// code.
absl::Status StatusOfResponse(const S3Request& request, const S3Answer& answer);

}  // namespace dcloc::server
