#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "core/geometry/geodetic_anchor.h"

namespace dcloc::cli {

/// Adds --anchor: where the drive's frame, and so its map's, lies on the Earth. An invalid anchor
/// is wrong usage.
CLI::Option* AddAnchorOption(CLI::App& command, std::optional<GeodeticAnchor>& anchor);

}  // namespace dcloc::cli
