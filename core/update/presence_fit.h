#pragma once

#include <span>
#include <vector>

#include "core/update/presence.h"

namespace dcloc {

/// The shapes and shares of `model` that explain `known` landmarks and `found` places best, as far
/// as there are enough of them. False hits and the rate of changes
/// stay as they are.
PresenceModel FitPresence(std::span<const std::vector<PassEvidence>> known,
                          std::span<const std::vector<PassEvidence>> found,
                          const PresenceModel& model);

}  // namespace dcloc
