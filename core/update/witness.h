#pragma once

#include <string>
#include <utility>

#include "core/update/placed_pass.h"

namespace dcloc {

/// A vehicle on a day: what passes of it say is one testimony.
using Witness = std::pair<std::string, long>;

/// When the first scan of `pass` that counts was taken. At least one does.
Stamp FirstGoodStamp(const PlacedPass& pass);

Witness WitnessOf(const PlacedPass& pass);

}  // namespace dcloc
