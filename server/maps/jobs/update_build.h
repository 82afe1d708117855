#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/maps/jobs/build_progress.h"
#include "server/maps/jobs/map_build.h"
#include "server/maps/store/map_store.h"
#include "server/passes/pass_store.h"

namespace dcloc::server {

/// What a map is brought up to date with.
struct UpdateSources {
  MapStore& store;
  PassStore& passes;
  std::string tenant;
  std::string map_name;          ///< without the tenant
  std::filesystem::path folder;  ///< for passes while they are read
  std::int64_t max_bytes = 0;    ///< of all of them
};

/// Makes a map file's bytes of a version and the passes that were kept since it was made
/// (`BuildUpdate`), and tells `progress` what became of each pass and how the new version was
/// judged. FailedPrecondition when it is no better, and says why. Aborted when a pass was removed
/// meanwhile; Cancelled when `progress` is stopped.
absl::StatusOr<std::vector<std::byte>> BuildFromPasses(const BuildRequest& request,
                                                       const UpdateSources& sources,
                                                       BuildProgress& progress);

}  // namespace dcloc::server
