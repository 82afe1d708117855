#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/evaluation/baselines/method.h"

namespace dcloc {

/// The map of `drive` that `kind` would have made: without the parts of the method that `options`
/// switch off, with the heights of landmarks if it is ours and `has_heights`, and for a method that
/// takes range rates from ego-motion, by those. `progress` receives the number of scans done.
/// Errors as of `BuildMap`.
absl::StatusOr<std::shared_ptr<const RadarMap>> MapForMethod(
    MethodKind kind, const Drive& drive, const LocalizerOptions& options, bool has_heights = true,
    const std::function<void(std::size_t)>& progress = [](std::size_t) {});

}  // namespace dcloc
