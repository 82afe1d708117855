#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/baselines/method.h"
#include "client/evaluation/paper/printed.h"

namespace dcloc::paper {

/// One way of localizing.
struct Variant {
  MethodKind method = MethodKind::kDcloc;
  bool doppler = true;
  bool uncertainty = true;
  bool truncation = true;
  int scans_per_submap = 10;
  bool calibrated = false;  ///< uses the rig calibrated on other data
  bool far_prior = false;   ///< begins 3 m and 5 degrees off, not 1 m and 2 degrees

  bool operator==(const Variant&) const = default;
};

/// "dc-loc", "icp-nodoppler", "dcloc-k5": unique, and fit for file names.
std::string VariantName(const Variant& variant);

/// A row of a table to be filled.
struct RowPlan {
  std::string label;
  Variant variant;
  std::optional<Printed> printed;  ///< the paper's numbers
};

/// Everything that Table I compares: the paper's methods, ICP and NDT also with compensation, which
/// the paper denies them, ours, and ours with a calibrated rig, which knows more than the others.
std::vector<RowPlan> Table1Rows();

/// Table II for DC-Loc++ or for ours.
std::vector<RowPlan> Table2Rows(MethodKind method);

/// Table III, ours.
std::vector<RowPlan> Table3Rows();

/// With the noises of Table IV: what Fig. 11 compares, compensated ICP, and both of ours.
std::vector<RowPlan> NoiseRows();

/// The methods of Fig. 11 and 12, and ours, which is last.
std::vector<RowPlan> FigureRows();

}  // namespace dcloc::paper
