#include "client/evaluation/faults/place_faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/geometry/degrees.h"

namespace dcloc::faults {
namespace {

// What is left between the scans on either side of a gap that was closed.
constexpr double kSeam_s = 0.02;

Fault MakePlaceFault(const std::string& id, std::string label, double begin_s, Fault::Apply apply) {
  return {.id = absl::StrCat("place-", id),
          .family = "place",
          .label = std::move(label),
          .begin_s = begin_s,
          .duration_s = 0.0,
          .apply = std::move(apply)};
}

double DistanceBetween(const StreamScan& a, const StreamScan& b) {
  return (a.T_map_vehicle.translation_m - b.T_map_vehicle.translation_m).norm();
}

/// Where a prior is wrong to: off to a side that the seed draws.
Fault::Apply Misplacing(double distance_m, double turn_deg, bool is_along) {
  return [=](Stream& stream, const Window&, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const double direction_rad =
        std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(random);
    Pose2 T_truth_prior;
    T_truth_prior.yaw_rad = turn_deg * kRadPerDeg;
    T_truth_prior.translation_m =
        is_along ? Eigen::Vector2d(direction_rad < 0.0 ? -distance_m : distance_m, 0.0)
                 : Eigen::Vector2d(distance_m * std::cos(direction_rad),
                                   distance_m * std::sin(direction_rad));
    MisplacePrior(stream, T_truth_prior);
  };
}

}  // namespace

void CarryAhead(Stream& stream, Stamp begin, double distance_m) {
  auto& scans = stream.scans;
  const auto first =
      std::ranges::find_if(scans, [&](const StreamScan& entry) { return entry.measured >= begin; });
  double carried_m = 0.0;
  auto next = first;
  while (next != scans.end() && carried_m < distance_m) {
    const auto previous = next++;
    if (next != scans.end()) carried_m += DistanceBetween(*previous, *next);
  }
  if (first == next) return;
  if (next != scans.end()) {
    const Stamp resume =
        first == scans.begin() ? first->measured : std::prev(first)->measured + Duration(kSeam_s);
    const auto gap = next->measured - std::max(resume, begin);
    for (auto entry = next; entry != scans.end(); ++entry) {
      entry->measured -= gap;
      entry->arrived -= gap;
      entry->scan.stamp -= gap;
    }
  }
  scans.erase(first, next);
}

void MisplacePrior(Stream& stream, const Pose2& T_truth_prior) {
  const double tilt_sigma_rad = 0.5 * kRadPerDeg;
  Vector6d sigmas;
  sigmas << 0.5, 0.5, 0.1, tilt_sigma_rad, tilt_sigma_rad, kRadPerDeg;
  stream.prior.T_map_vehicle = stream.scans.front().T_map_vehicle * Embed(T_truth_prior);
  stream.prior.covariance = sigmas.cwiseAbs2().asDiagonal();
}

std::vector<Fault> PlaceFaults() {
  std::vector<Fault> faults;
  for (const int distance_m : {20, 100}) {
    faults.push_back(MakePlaceFault(
        absl::StrCat("skipped-", distance_m, "m"), absl::StrCat("carried ", distance_m, " m ahead"),
        Fault::kBegin_s, [=](Stream& stream, const Window& window, std::uint64_t) {
          CarryAhead(stream, window.begin, distance_m);
        }));
  }
  faults.push_back(MakePlaceFault("prior-20m", "prior 20 m off, claims 0.5 m and 1 deg", 0.0,
                                  Misplacing(20.0, 0.0, false)));
  // Guard rails have a post every 4 m. By their posts, places that are further apart look alike,
  // too.
  for (const int distance_m : {4, 6, 40, 100}) {
    faults.push_back(MakePlaceFault(
        absl::StrCat("prior-", distance_m, "m"),
        absl::StrCat("prior ", distance_m, " m off along the way, claims 0.5 m and 1 deg"), 0.0,
        Misplacing(distance_m, 0.0, true)));
  }
  faults.push_back(MakePlaceFault("prior-180deg", "prior turned round, claims 0.5 m and 1 deg", 0.0,
                                  Misplacing(0.0, 180.0, true)));
  return faults;
}

}  // namespace dcloc::faults
