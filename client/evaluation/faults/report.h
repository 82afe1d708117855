#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/evaluation/faults/rows.h"
#include "client/evaluation/robustness/cells.h"

namespace dcloc::faults {

/// A row for each fault, all worlds together; by kind of world below it where `by_kind`.
robustness::TextTable FaultText(std::span<const FaultRows> rows, bool by_kind);

/// What ended otherwise than with an answer or a refusal; the header alone where nothing did.
robustness::TextTable FailureText(std::span<const FaultRows> rows);

/// A self-contained page. `stanford_svg` is the diagram, or empty where no answer has a protection
/// level, or it cannot be drawn; `stanford_remark` says which.
std::string FaultHtml(std::span<const FaultRows> rows,
                      const std::vector<std::pair<std::string, std::string>>& settings,
                      const std::string& stanford_svg, const std::string& stanford_remark);

}  // namespace dcloc::faults
