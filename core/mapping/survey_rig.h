#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/calibration/calibration.h"
#include "core/mapping/joined_rig.h"
#include "core/radar/radar_model.h"

namespace dcloc {

/// A vehicle that took part in a survey.
struct SurveyVehicle {
  Rig rig;  ///< as it is known now, its radars named as in the joined rig
  std::vector<std::string> drives;

  bool Drove(const std::string& drive) const;
};

/// What a survey knows of the radars of all drives: their descriptions, and what it found wrong
/// with them. Radars are named as in the joined rig.
class SurveyRig {
 public:
  /// A drive, with its radars as they are described. One that was added before changes nothing.
  void Add(const std::string& drive, const Rig& rig);

  std::string IdOf(const std::string& drive, const RadarModel& described) const {
    return joined_.IdOf(drive, described);
  }

  /// The radars of a drive that was added, with their own ids, as they are known now.
  Rig Of(const std::string& drive, const Rig& described) const;

  /// All radars, as they are known now.
  Rig Known() const;

  /// Drives that have a radar in common are of one vehicle.
  std::vector<SurveyVehicle> Vehicles() const;

  /// Takes what a calibration by the drives' own poses found wrong with radars as they are known
  /// now (`ChooseApplied`); what then is no longer significant against their description is taken
  /// back. Whether radars are known to be other than before.
  bool Learn(Calibration found);

  /// What was found of each radar so far, against its description; empty before `Learn`.
  std::span<const RadarCalibration> calibrations() const { return calibrations_; }

 private:
  const RadarCalibration* CalibrationOf(const std::string& id) const;

  struct VehicleIds {
    std::vector<std::string> radars;
    std::vector<std::string> drives;
  };

  JoinedRig joined_;
  std::vector<VehicleIds> vehicles_;
  std::vector<RadarCalibration> calibrations_;
};

}  // namespace dcloc
