#include "server/maps/store/map_files.h"

#include <utility>

#include "server/maps/store/read_map.h"

namespace dcloc::server {

absl::StatusOr<std::shared_ptr<const RadarMap>> MapFiles::Open(absl::string_view sha256) {
  absl::StatusOr<std::vector<std::byte>> bytes = Read(sha256);
  if (!bytes.ok()) return bytes.status();
  return MapOf(*std::move(bytes));
}

}  // namespace dcloc::server
