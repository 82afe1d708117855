#include "client/datasets/drive_request.h"

#include "client/datasets/files/check_range.h"

namespace dcloc {

absl::Status Validate(const DriveRequest& request) {
  constexpr double kForever = std::numeric_limits<double>::infinity();
  absl::Status status = CheckRange("begin_s", request.begin_s, 0.0, kForever);
  status.Update(CheckRange("end_s", request.end_s, 0.0, kForever));
  if (request.beta_s) status.Update(CheckRange("beta_s", *request.beta_s, -1.0, 1.0));
  return status;
}

}  // namespace dcloc
