#include "server/passes/pass_file.h"

#include "absl/strings/str_format.h"
#include "server/convert/scan.h"

namespace dcloc::server {

absl::StatusOr<Rig> PassFile::ReadRig() {
  if (absl::Status status = file_.Begin(); !status.ok()) return status;
  v1::PassHeader header;
  const absl::StatusOr<bool> there = file_.Next(&header);
  if (!there.ok()) return there.status();
  if (!*there) return absl::DataLossError("the file of a pass is empty");
  if (header.format_version() != kPassFormatVersion) {
    return absl::DataLossError(
        absl::StrFormat("the pass has format version %d; this program knows %d",
                        header.format_version(), kPassFormatVersion));
  }
  absl::StatusOr<Rig> rig = convert::FromProto(header.rig(), "rig");
  if (rig.ok()) rig_ = *rig;
  return rig;
}

absl::StatusOr<bool> PassFile::Next(Scan* scan) {
  absl::StatusOr<bool> there = file_.Next(&entry_);
  if (!there.ok() || !*there) return there;
  if (absl::Status status = convert::FromProto(entry_.scan(), rig_, scan); !status.ok()) {
    return status;
  }
  return true;
}

}  // namespace dcloc::server
