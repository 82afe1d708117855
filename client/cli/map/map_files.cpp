#include "client/cli/map/map_files.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/common/atomic_file.h"

namespace dcloc::cli {
namespace {

absl::Status Named(const std::string& file, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(file, ": ", status.message()));
}

}  // namespace

absl::StatusOr<MapParts> ReadMapParts(const std::string& file) {
  const auto map = RadarMap::Open(file);
  if (!map.ok()) return map.status();
  if (absl::Status status = (*map)->Verify(); !status.ok()) return Named(file, status);
  return TakeApart(**map);
}

absl::StatusOr<MapInfo> WriteMapParts(const MapParts& map, const std::string& file) {
  absl::StatusOr<std::vector<std::byte>> bytes = PutTogether(map);
  if (!bytes.ok()) return Named(file, bytes.status());
  if (absl::Status status = WriteFileAtomically(file, *bytes); !status.ok()) return status;
  const auto written = RadarMap::FromBytes(*std::move(bytes));
  if (!written.ok()) return Named(file, written.status());
  return (*written)->info();
}

}  // namespace dcloc::cli
