#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/faults/fault_list.h"
#include "client/evaluation/faults/record.h"
#include "client/evaluation/result_store.h"

namespace dcloc::faults {

/// The drive as it is, and the same driven backwards: what faults are compared with.
inline constexpr const char* kUndisturbed = "undisturbed";
inline constexpr const char* kUndisturbedReversing = "undisturbed-reversing";

/// What became of a fault in a world.
struct CaseResult {
  std::string world;
  std::string kind;   ///< of the world
  std::string fault;  ///< its id, kUndisturbed or kUndisturbedReversing
  Record record;
};

/// Is called from several threads, each with names of its own.
using RecordStore = ResultStore<Record>;

/// Every fault of the selection in every world that it says something of, and the worlds as they
/// are, as far as `store` does not hold them; `jobs` (> 0) worlds at a time. Sessions begin 0.5 m
/// and 2 degrees off. `progress`, called by one thread at a time, is told what has been done and
/// the share of the whole. Errors name the case.
absl::StatusOr<std::vector<CaseResult>> RunFaultCampaign(
    const Selection& selection, RecordStore& store, int jobs,
    const std::function<void(const std::string&, double)>& progress);

}  // namespace dcloc::faults
