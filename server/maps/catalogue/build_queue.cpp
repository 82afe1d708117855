#include "server/maps/catalogue/build_queue.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {

absl::Status NoSuchBuild(absl::string_view build_id) {
  return absl::NotFoundError(absl::StrCat("build_id is ", Quoted(build_id),
                                          "; there is no such build, or it ended too long ago"));
}

absl::Status TooManyBuilds(int max_running) {
  return absl::ResourceExhaustedError(
      absl::StrFormat("%d builds are under way, which is the limit", max_running));
}

}  // namespace dcloc::server
