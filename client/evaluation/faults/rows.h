#pragma once

#include <span>
#include <string>
#include <vector>

#include "client/evaluation/faults/campaign.h"

namespace dcloc::faults {

/// A fault in some worlds together, beside the same worlds as they are.
struct FaultRow {
  std::string name;  ///< the fault's label, or the kind of world
  Record record;
  Record undisturbed;
};

/// A fault in all worlds, and in those of each kind.
struct FaultRows {
  std::string id;
  std::string family;
  FaultRow all;
  std::vector<FaultRow> by_kind;
};

/// The worlds as they are, then the faults in their order; those without results stay out.
std::vector<FaultRows> RowsOf(std::span<const CaseResult> results,
                              const std::vector<Fault>& faults);

}  // namespace dcloc::faults
