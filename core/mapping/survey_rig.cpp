#include "core/mapping/survey_rig.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/calibration/applied_corrections.h"

namespace dcloc {
namespace {

bool Holds(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

void AddNames(const std::vector<std::string>& added, std::vector<std::string>& names) {
  for (const std::string& name : added) {
    if (!Holds(names, name)) names.push_back(name);
  }
}

}  // namespace

bool SurveyVehicle::Drove(const std::string& drive) const { return Holds(drives, drive); }

void SurveyRig::Add(const std::string& drive, const Rig& rig) {
  joined_.Add(drive, rig);
  VehicleIds vehicle{.radars = {}, .drives = {drive}};
  for (const RadarModel& radar : rig.radars) vehicle.radars.push_back(IdOf(drive, radar));
  std::erase_if(vehicles_, [&](const VehicleIds& other) {
    const bool is_same = std::ranges::any_of(
        other.radars, [&](const std::string& id) { return Holds(vehicle.radars, id); });
    if (is_same) {
      AddNames(other.radars, vehicle.radars);
      AddNames(other.drives, vehicle.drives);
    }
    return is_same;
  });
  vehicles_.push_back(std::move(vehicle));
}

const RadarCalibration* SurveyRig::CalibrationOf(const std::string& id) const {
  const auto at = std::ranges::find(
      calibrations_, id, [](const RadarCalibration& radar) { return radar.described.id; });
  return at == calibrations_.end() ? nullptr : &*at;
}

Rig SurveyRig::Of(const std::string& drive, const Rig& described) const {
  Rig rig = described;
  for (RadarModel& radar : rig.radars) {
    const RadarCalibration* const calibration = CalibrationOf(IdOf(drive, radar));
    if (calibration == nullptr) continue;
    const std::string id = radar.id;
    radar = Calibrated(*calibration);
    radar.id = id;
  }
  return rig;
}

Rig SurveyRig::Known() const {
  Rig rig = joined_.rig();
  for (RadarModel& radar : rig.radars) {
    const RadarCalibration* const calibration = CalibrationOf(radar.id);
    if (calibration != nullptr) radar = Calibrated(*calibration);
  }
  return rig;
}

std::vector<SurveyVehicle> SurveyRig::Vehicles() const {
  const Rig known = Known();
  std::vector<SurveyVehicle> vehicles;
  for (const VehicleIds& ids : vehicles_) {
    SurveyVehicle& vehicle = vehicles.emplace_back();
    vehicle.drives = ids.drives;
    for (const RadarModel& radar : known.radars) {
      if (Holds(ids.radars, radar.id)) vehicle.rig.radars.push_back(radar);
    }
  }
  return vehicles;
}

// What was found is applied where it is significant, and stays where all that was found so far is.
bool SurveyRig::Learn(Calibration found) {
  ChooseApplied(found, /*poses_are_own=*/true);
  for (RadarCalibration& radar : found.radars) {
    const RadarCalibration* const before = CalibrationOf(radar.described.id);
    for (std::size_t kind = 0; kind < kCalibrationParameters; ++kind) {
      CalibratedParameter& parameter = radar.parameters.at(kind);
      parameter.correction =
          parameter.applied + (before == nullptr ? 0.0 : before->parameters.at(kind).applied);
    }
    if (before != nullptr) radar.described = before->described;
  }
  ChooseApplied(found, /*poses_are_own=*/true);
  bool is_changed = false;
  for (RadarCalibration& radar : found.radars) {
    const RadarCalibration* const before = CalibrationOf(radar.described.id);
    for (std::size_t kind = 0; kind < kCalibrationParameters; ++kind) {
      const double applied_before = before == nullptr ? 0.0 : before->parameters.at(kind).applied;
      is_changed = is_changed || radar.parameters.at(kind).applied != applied_before;
    }
    // What all clocks have in common is known as well as before.
    radar.parameters.at(static_cast<std::size_t>(CalibrationParameter::kTimeOffset))
        .remaining_sigma = radar.described.time_offset_sigma_s;
    std::erase_if(calibrations_, [&](const RadarCalibration& other) {
      return other.described.id == radar.described.id;
    });
    calibrations_.push_back(std::move(radar));
  }
  return is_changed;
}

}  // namespace dcloc
