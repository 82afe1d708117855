#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/update/map_update.h"
#include "core/update/placed_pass.h"
#include "core/update/update_gate.h"

namespace dcloc::cli {

/// An update with all that is told of it.
struct UpdateReport {
  std::string base;
  std::string held_out;
  std::vector<PlacedPass> passes;   ///< without their points
  std::vector<std::string> faults;  ///< of each pass; empty where it is of use
  MapUpdate update;
  UpdateEvaluation gate;
  std::string out;  ///< the file that was written; empty where none was
};

/// What came, what went, where and since when; how the passes fared; how each street was judged and
/// when it was last driven.
nlohmann::ordered_json UpdateJson(const UpdateReport& report);
std::string UpdateText(const UpdateReport& report);

/// The same as a page with a drawing.
std::string UpdateHtml(const UpdateReport& report);

}  // namespace dcloc::cli
