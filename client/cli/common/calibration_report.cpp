#include "client/cli/common/calibration_report.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"
#include "client/datasets/drive_calibration.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

// Those of the radar's description; heights only help to find them.
constexpr std::array<CalibrationParameter, 4> kDescribed = {
    CalibrationParameter::kBeta, CalibrationParameter::kTimeOffset,
    CalibrationParameter::kRangeBias, CalibrationParameter::kMountYaw};

// * for what is applied, (*) for a part; ? for what is not determined, nor was left alone.
const char* Mark(const CalibratedParameter& value) {
  if (value.prior_sigma == 0.0) return "";
  if (value.applied != 0.0) return value.applied == value.correction ? "*" : "(*)";
  return value.determined() ? "" : "?";
}

// "+0.0401 +-0.0012 *"
std::string Cell(const RadarCalibration& radar, CalibrationParameter parameter, double unit,
                 int digits) {
  const CalibratedParameter& value = radar.of(parameter);
  return absl::StrFormat("%+.*f +-%.*f %-3s", digits, value.correction / unit, digits,
                         kSigmas95 * value.sigma / unit, Mark(value));
}

std::string ConfusionsText(const Calibration& calibration) {
  std::string text;
  for (const Confusion& confusion : calibration.Confusions()) {
    absl::StrAppendFormat(
        &text, "The data hardly tell %s of %s from %s of %s (correlation %+.2f).\n",
        NameOf(confusion.parameter), confusion.radar, NameOf(confusion.other_parameter),
        confusion.other_radar, confusion.correlation);
  }
  return text;
}

}  // namespace

ordered_json RigFileJson(std::span<const RadarCalibration> radars) {
  ordered_json entries = ordered_json::array();
  for (const RadarCalibration& radar : radars) {
    const RadarModel calibrated = Calibrated(radar);
    entries.push_back(
        {{"id", radar.described.id},
         {"beta_s", calibrated.beta_s},
         {"time_offset_s", calibrated.time_offset_s},
         {"range_bias_m", calibrated.range_bias_m},
         {"mount_yaw_correction_rad", radar.of(CalibrationParameter::kMountYaw).applied},
         {"beta_sigma_s", calibrated.beta_sigma_s},
         {"time_offset_sigma_s", calibrated.time_offset_sigma_s},
         {"range_bias_sigma_m", calibrated.range_bias_sigma_m},
         {"mount_yaw_sigma_rad", calibrated.mount_yaw_sigma_rad}});
  }
  return {{"radars", std::move(entries)}};
}

ordered_json RadarCalibrationsJson(std::span<const RadarCalibration> radars) {
  ordered_json entries = ordered_json::array();
  for (const RadarCalibration& radar : radars) {
    ordered_json entry = {{"id", radar.described.id}, {"described_beta_s", radar.described.beta_s}};
    for (const CalibrationParameter parameter : kDescribed) {
      const CalibratedParameter& value = radar.of(parameter);
      entry[NameOf(parameter)] = {{"correction", value.correction},
                                  {"sigma", value.sigma},
                                  {"interval_95",
                                   {value.correction - kSigmas95 * value.sigma,
                                    value.correction + kSigmas95 * value.sigma}},
                                  {"determined", value.determined()},
                                  {"significant", value.significant()},
                                  {"applied", value.applied}};
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

ordered_json CalibrationJson(const Calibration& calibration) {
  ordered_json json = {{"returns", calibration.return_count}, {"pairs", calibration.pair_count}};
  json["radars"] = RadarCalibrationsJson(calibration.radars);
  json["confusions"] = ordered_json::array();
  for (const Confusion& confusion : calibration.Confusions()) {
    json["confusions"].push_back({{"radar", confusion.radar},
                                  {"parameter", NameOf(confusion.parameter)},
                                  {"other_radar", confusion.other_radar},
                                  {"other_parameter", NameOf(confusion.other_parameter)},
                                  {"correlation", confusion.correlation}});
  }
  return json;
}

std::vector<std::vector<std::string>> RadarCalibrationRows(
    std::span<const RadarCalibration> radars) {
  std::vector<std::vector<std::string>> rows = {
      {"radar", "beta [s]", "time offset [s]", "range bias [m]", "mount yaw [deg]"}};
  for (const RadarCalibration& radar : radars) {
    rows.push_back({radar.described.id, Cell(radar, CalibrationParameter::kBeta, 1.0, 4),
                    Cell(radar, CalibrationParameter::kTimeOffset, 1.0, 4),
                    Cell(radar, CalibrationParameter::kRangeBias, 1.0, 3),
                    Cell(radar, CalibrationParameter::kMountYaw, kRadPerDeg, 3)});
  }
  return rows;
}

std::string CalibrationText(const Calibration& calibration) {
  return absl::StrCat(
      FormatTable(RadarCalibrationRows(calibration.radars)),
      "Corrections to the description with their 95 % intervals, from ", calibration.return_count,
      " static returns\nand ", calibration.pair_count,
      " pairs of them. * is applied to the rig, (*) only what all radars have in common"
      "\nor only how they differ from it; ? the data hardly determine.\n",
      ConfusionsText(calibration));
}

}  // namespace dcloc::cli
