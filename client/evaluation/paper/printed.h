#pragma once

#include <array>
#include <optional>

namespace dcloc::paper {

/// What the DC-Loc++ paper prints of one row of a table: errors over the pairs on which every
/// method succeeds.
struct Printed {
  double rte_mean_m, rte_median_m, rre_mean_deg, rre_median_deg, success_percent;
  std::optional<double> time_ms;
};

// Table I, nuScenes.
inline constexpr Printed kIcp = {0.529, 0.398, 1.760, 0.683, 84.8, {}};
inline constexpr Printed kNdt = {0.415, 0.351, 1.249, 0.506, 89.6, {}};
inline constexpr Printed kMcRansac = {0.385, 0.255, 1.108, 0.523, 90.8, {}};
inline constexpr Printed kDcLoc = {0.269, 0.181, 0.964, 0.489, 90.2, {}};
inline constexpr Printed kDcLocPlusPlus = {0.215, 0.142, 0.673, 0.464, 99.2, 260.1};

/// Table II: which of Doppler compensation, uncertainty and truncated pose graph are on.
struct AblationRow {
  bool doppler, uncertainty, truncation;
  Printed printed;
};
inline constexpr std::array<AblationRow, 8> kTable2 = {{
    {false, false, false, {0.375, 0.289, 1.077, 0.503, 90.7, {}}},
    {true, false, false, {0.297, 0.191, 1.033, 0.495, 90.7, {}}},
    {false, true, false, {0.365, 0.288, 1.066, 0.489, 90.7, {}}},
    {true, true, false, {0.269, 0.181, 0.964, 0.489, 90.2, {}}},
    {false, false, true, {0.309, 0.265, 0.683, 0.468, 98.8, {}}},
    {true, false, true, {0.220, 0.146, 0.678, 0.463, 99.0, {}}},
    {false, true, true, {0.314, 0.264, 0.678, 0.469, 99.2, {}}},
    {true, true, true, {0.215, 0.142, 0.673, 0.464, 99.2, {}}},
}};

/// Table III: scans in a sub-map.
struct SubmapRow {
  int scans;
  Printed printed;
};
inline constexpr std::array<SubmapRow, 7> kTable3 = {{
    {1, {0.463, 0.314, 0.990, 0.543, 96.2, 10.4}},
    {3, {0.314, 0.185, 0.772, 0.480, 98.9, 42.3}},
    {5, {0.261, 0.161, 0.691, 0.466, 98.9, 80.6}},
    {8, {0.225, 0.151, 0.675, 0.454, 99.2, 156.5}},
    {10, {0.215, 0.142, 0.673, 0.464, 99.2, 202.6}},
    {13, {0.240, 0.151, 0.696, 0.490, 99.3, 374.9}},
    {15, {0.247, 0.154, 0.712, 0.496, 99.4, 411.7}},
}};

/// Fig. 11: by how many percent DC-Loc++'s translation error lies below others' with each noise.
struct NoiseRow {
  double below_mc_ransac_percent, below_dc_loc_percent;
};
inline constexpr std::array<NoiseRow, 4> kFigure11 = {
    {{51.9, 15.1}, {53.4, 11.8}, {52.7, 12.3}, {37.5, 13.4}}};

// Table V.
inline constexpr double kCompensation_ms = 56.8;
inline constexpr double kRegistration_ms = 202.6;
inline constexpr double kPoseGraph_ms = 0.7;
inline constexpr double kTotal_ms = 260.1;

}  // namespace dcloc::paper
