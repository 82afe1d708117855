#include "client/evaluation/faults/radar_faults.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/faults/time_faults.h"
#include "core/geometry/degrees.h"

namespace dcloc::faults {
namespace {

template <typename Change>
void ChangeScansOf(Stream& stream, const Window& window, const std::string& radar_id,
                   const Change& change) {
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured) && entry.scan.radar_id == radar_id) change(entry.scan);
  }
}

/// A change of the rig's first radar.
using ChangeOfRadar = std::function<void(Stream&, const Window&, const std::string& radar_id)>;

Fault MakeRadarFault(const std::string& id, std::string label, std::optional<double> duration_s,
                     ChangeOfRadar change) {
  return {
      .id = absl::StrCat("radar-", id),
      .family = "radar",
      .label = std::move(label),
      .duration_s = duration_s,
      .apply = [change = std::move(change)](Stream& stream, const Window& window, std::uint64_t) {
        change(stream, window, stream.rig.radars.front().id);
      }};
}

Fault FromStart(Fault fault) {
  fault.id += "-start";
  fault.label += ", from the start";
  fault.begin_s = 0.0;
  return fault;
}

void AddSilence(std::vector<Fault>& faults) {
  const auto silence = [](Stream& stream, const Window& window, const std::string& radar_id) {
    SilenceRadar(stream, window, radar_id);
  };
  const auto silence_all = [](Stream& stream, const Window& window, const std::string&) {
    SilenceRadar(stream, window, std::nullopt);
  };
  for (const std::optional<double> duration_s : {std::optional<double>(10.0), {}}) {
    faults.push_back(MakeRadarFault(duration_s ? "silent-10s" : "silent",
                                    duration_s ? "one radar silent for 10 s" : "one radar silent",
                                    duration_s, silence));
    faults.back().min_radars = 2;
  }
  for (const int seconds : {2, 10}) {
    faults.push_back(MakeRadarFault(absl::StrCat("all-silent-", seconds, "s"),
                                    absl::StrCat("all radars silent for ", seconds, " s"), seconds,
                                    silence_all));
  }
}

void AddMounts(std::vector<Fault>& faults) {
  const double yaw_rad = 10.0 * kRadPerDeg;
  faults.push_back(
      MakeRadarFault("mirrored", "sign of one radar's azimuths wrong", std::nullopt,
                     [](Stream& stream, const Window& window, const std::string& radar_id) {
                       MirrorAzimuth(stream, window, radar_id);
                     }));
  faults.back().begin_s = 0.0;
  faults.push_back(MakeRadarFault("mount-10deg", "one radar described 10 deg off", std::nullopt,
                                  [=](Stream& stream, const Window&, const std::string& radar_id) {
                                    TurnMount(stream, radar_id, yaw_rad);
                                  }));
  faults.back().begin_s = 0.0;
  faults.push_back(
      MakeRadarFault("knocked-10deg", "one radar knocked by 10 deg", std::nullopt,
                     [=](Stream& stream, const Window& window, const std::string& radar_id) {
                       KnockRadar(stream, window, radar_id, yaw_rad);
                     }));
}

void AddRangeRates(std::vector<Fault>& faults) {
  struct Change {
    const char* id;
    const char* label;
    double factor;
    double offset_mps;
  };
  for (const Change& change :
       {Change{"rate-sign", "sign of one radar's range rates wrong", -1.0, 0.0},
        Change{"rate-1.3", "one radar's range rates times 1.3", 1.3, 0.0},
        Change{"rate-1.07", "one radar's range rates times 1.07", 1.07, 0.0},
        Change{"rate-0.6", "one radar's range rates times 0.6", 0.6, 0.0},
        Change{"rate+1mps", "one radar's range rates 1 m/s too high", 1.0, 1.0}}) {
    faults.push_back(MakeRadarFault(
        change.id, change.label, std::nullopt,
        [=](Stream& stream, const Window& window, const std::string& radar_id) {
          ChangeRangeRate(stream, window, radar_id, change.factor, change.offset_mps);
        }));
    faults.push_back(FromStart(faults.back()));
  }
}

void AddClockAndSigmas(std::vector<Fault>& faults) {
  for (const double shift_s : {0.1, 0.2, -0.2, 5.0, -5.0}) {
    faults.push_back(
        MakeRadarFault(absl::StrCat("clock", shift_s < 0.0 ? "" : "+", shift_s, "s"),
                       absl::StrCat("one radar's stamps off by ", shift_s, " s"), std::nullopt,
                       [=](Stream& stream, const Window& window, const std::string& radar_id) {
                         ShiftStamps(stream, window, Duration(shift_s), radar_id);
                       }));
    if (std::abs(shift_s) > 1.0) continue;
    faults.push_back(FromStart(faults.back()));
    faults.back().min_radars = 2;
  }
  faults.push_back(MakeRadarFault("sigmas", "stated deviations of 1e30 for 10 s", 10.0,
                                  [](Stream& stream, const Window& window, const std::string&) {
                                    StateSigmas(stream, window, 1e30F);
                                  }));
}

}  // namespace

void SilenceRadar(Stream& stream, const Window& window,
                  const std::optional<std::string>& radar_id) {
  std::erase_if(stream.scans, [&](const StreamScan& entry) {
    return window.Contains(entry.measured) && (!radar_id || entry.scan.radar_id == *radar_id);
  });
}

void MirrorAzimuth(Stream& stream, const Window& window, const std::string& radar_id) {
  ChangeScansOf(stream, window, radar_id, [](Scan& scan) {
    for (float& azimuth_rad : scan.azimuth_rad) azimuth_rad = -azimuth_rad;
  });
}

void KnockRadar(Stream& stream, const Window& window, const std::string& radar_id, double yaw_rad) {
  ChangeScansOf(stream, window, radar_id, [&](Scan& scan) {
    for (float& azimuth_rad : scan.azimuth_rad) {
      azimuth_rad = static_cast<float>(WrapAngle(static_cast<double>(azimuth_rad) - yaw_rad));
    }
  });
}

void TurnMount(Stream& stream, const std::string& radar_id, double yaw_rad) {
  for (RadarModel& radar : stream.rig.radars) {
    if (radar.id != radar_id) continue;
    radar.T_vehicle_radar.rotation =
        Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * radar.T_vehicle_radar.rotation;
  }
}

void ChangeRangeRate(Stream& stream, const Window& window, const std::string& radar_id,
                     double factor, double offset_mps) {
  ChangeScansOf(stream, window, radar_id, [&](Scan& scan) {
    for (float& range_rate_mps : scan.range_rate_mps) {
      range_rate_mps =
          static_cast<float>(factor * static_cast<double>(range_rate_mps) + offset_mps);
    }
  });
}

void StateSigmas(Stream& stream, const Window& window, float sigma) {
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured)) continue;
    Scan& scan = entry.scan;
    for (std::vector<float>* column :
         {&scan.range_sigma_m, &scan.range_rate_sigma_mps, &scan.azimuth_sigma_rad}) {
      column->assign(scan.size(), sigma);
    }
    if (!scan.elevation_rad.empty()) scan.elevation_sigma_rad.assign(scan.size(), sigma);
  }
}

std::vector<Fault> RadarFaults() {
  std::vector<Fault> faults;
  AddSilence(faults);
  AddMounts(faults);
  AddRangeRates(faults);
  AddClockAndSigmas(faults);
  return faults;
}

}  // namespace dcloc::faults
