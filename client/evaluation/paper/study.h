#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/evaluation/outcome.h"
#include "client/evaluation/paper/table_rows.h"
#include "client/evaluation/result_store.h"
#include "client/evaluation/runner.h"

namespace dcloc::paper {

/// A drive to make the map of and one to localize in it, in one frame.
struct DrivePair {
  Drive map;
  Drive live;
};

/// Which questions are asked of a case.
enum class Purpose {
  kMethods,    ///< all methods (Table I)
  kAblations,  ///< these, and the ablations and sub-map sizes (Tables II and III)
  kNoise,      ///< those of Table IV
};

/// One pair of drives of a set that is reported together.
struct Case {
  std::string set;   ///< for people
  std::string name;  ///< unique; letters, digits, '-', '_' and '+'
  Purpose purpose = Purpose::kMethods;
  double query_interval_s = 0.5;
  std::function<absl::StatusOr<DrivePair>()> load;
  /// Drives, with all radars of both, on which the rig is calibrated; none of them is the live one.
  /// Without it nothing is run calibrated.
  std::function<absl::StatusOr<std::vector<Drive>>()> load_calibration;
};

/// One run: a variant over a case by a protocol. Each scan's speed difference is set.
struct RunResult {
  std::string set;
  std::string case_name;
  Variant variant;
  Protocol protocol = Protocol::kTrack;
  DriveOutcome outcome;
};

struct Run {
  Variant variant;
  Protocol protocol;
};

/// Between registrations of ICP and NDT in a session: PCL's take twenty times ours, and so short a
/// way by odometry adds nothing to their errors that would be seen.
inline constexpr auto kPclRegistrationInterval = std::chrono::milliseconds(200);

/// The runs of a case. `quick` leaves out most ablations and sub-map sizes.
std::vector<Run> PlanRuns(const Case& item, bool quick);

/// "<case>.<variant>.<track|pairs>"
std::string RunName(const Case& item, const Run& run);

/// Does all runs of all cases that `store` does not hold. `progress` receives what is being done
/// and the share of the whole study done. The outcomes hold no maps.
absl::StatusOr<std::vector<RunResult>> RunStudy(
    const std::vector<Case>& cases, bool quick, ResultStore<DriveOutcome>& store,
    const std::function<void(const std::string&, double)>& progress);

}  // namespace dcloc::paper
