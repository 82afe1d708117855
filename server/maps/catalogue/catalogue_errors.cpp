#include "server/maps/catalogue/catalogue_errors.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {

absl::Status NoSuchMap(absl::string_view map_name) {
  return absl::NotFoundError(
      absl::StrCat("map_name is ", Quoted(map_name), "; there is no such map"));
}

absl::Status NoSuchVersion(absl::string_view map_name, std::int64_t version) {
  return absl::NotFoundError(
      absl::StrFormat("version is %d; map %s has no such version", version, Quoted(map_name)));
}

absl::Status NoActiveVersion(absl::string_view map_name) {
  return absl::FailedPreconditionError(
      absl::StrCat("map ", Quoted(map_name), " has no active version"));
}

absl::Status VersionInUse(absl::string_view map_name, std::int64_t version) {
  return absl::FailedPreconditionError(
      absl::StrFormat("version %d of map %s is in use; its sessions and downloads must end first",
                      version, Quoted(map_name)));
}

absl::Status VersionBeingDeleted(absl::string_view map_name) {
  return absl::UnavailableError(
      absl::StrCat("a version of map ", Quoted(map_name), " is being deleted; try again"));
}

absl::Status FileHeld(absl::string_view sha256, absl::string_view holder) {
  return absl::UnavailableError(
      absl::StrCat("file ", sha256, " is being stored or removed by ", holder, "; try again"));
}

absl::Status CheckMayBeDeleted(const MapRecord& map, std::int64_t version) {
  if (map.canary_version == version) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "version %d of map %s is the canary; set another one or none", version, Quoted(map.name)));
  }
  if (map.active_version == version) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "version %d of map %s is active; activate another one or delete the whole map", version,
        Quoted(map.name)));
  }
  return absl::OkStatus();
}

absl::Status CheckMayBeCanary(const MapRecord& map, std::int64_t version) {
  if (map.active_version != version) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrFormat("version is %d; it is the active one of map %s", version, Quoted(map.name)));
}

}  // namespace dcloc::server
