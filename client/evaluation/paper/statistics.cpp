#include "client/evaluation/paper/statistics.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "client/evaluation/metrics.h"

namespace dcloc::paper {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kBin_mps = 2.0;

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Of Student's distribution, from the normal one's by Cornish and Fisher's expansion: to 0.5 % from
// five degrees of freedom on.
double StudentQuantile975(double degrees_of_freedom) {
  constexpr double kZ = 1.959964;
  constexpr double kFirst = (kZ * kZ * kZ + kZ) / 4.0;
  constexpr double kSecond = (5.0 * kZ * kZ * kZ * kZ * kZ + 16.0 * kZ * kZ * kZ + 3.0 * kZ) / 96.0;
  return kZ + kFirst / degrees_of_freedom + kSecond / (degrees_of_freedom * degrees_of_freedom);
}

// One answer of the regression: (1, |speed difference|), error.
struct Sample {
  Eigen::Vector2d x;
  double error_m;
};

// By segment of five seconds of a drive.
using Clusters = std::map<std::pair<std::size_t, std::int64_t>, std::vector<Sample>>;

Clusters Cluster(std::span<const DriveOutcome> outcomes) {
  Clusters clusters;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    for (const ScanOutcome& scan : outcomes[i].scans) {
      if (!IsSuccess(scan) || !scan.speed_difference_mps) continue;
      const auto segment =
          std::chrono::floor<std::chrono::seconds>(scan.answer.stamp.time_since_epoch()).count() /
          5;
      clusters[{i, segment}].push_back(
          {{1.0, std::abs(*scan.speed_difference_mps)}, scan.error.translation_m});
    }
  }
  return clusters;
}

}  // namespace

std::vector<DriveOutcome> CommonSuccesses(std::span<const DriveOutcome* const> outcomes) {
  std::map<std::pair<Stamp, std::string>, std::size_t> successes;
  for (const DriveOutcome* outcome : outcomes) {
    for (const ScanOutcome& scan : outcome->scans) {
      if (IsSuccess(scan)) ++successes[{scan.answer.stamp, scan.radar_id}];
    }
  }
  std::vector<DriveOutcome> common;
  for (const DriveOutcome* outcome : outcomes) {
    DriveOutcome& kept = common.emplace_back();
    kept.drive = outcome->drive;
    for (const ScanOutcome& scan : outcome->scans) {
      const auto found = successes.find({scan.answer.stamp, scan.radar_id});
      if (found != successes.end() && found->second == outcomes.size()) kept.scans.push_back(scan);
    }
  }
  return common;
}

Slope ErrorSlope(std::span<const DriveOutcome> outcomes) {
  const Clusters clusters = Cluster(outcomes);
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Slope slope{.m_per_mps = kNan, .low = kNan, .high = kNan};
  for (const auto& [key, samples] : clusters) {
    for (const Sample& sample : samples) {
      normal += sample.x * sample.x.transpose();
      right += sample.x * sample.error_m;
      ++slope.answer_count;
    }
  }
  const auto cluster_count = static_cast<double>(clusters.size());
  const double spread = normal.determinant() / std::pow(std::max(1.0, normal(0, 0)), 2);
  constexpr double kMinSpread = 0.01;  // (m/s)^2: all speed differences are the same
  constexpr std::size_t kMinClusters = 6;
  if (clusters.size() < kMinClusters || !(spread > kMinSpread)) return slope;

  const Eigen::Matrix2d inverse = normal.inverse();
  const Eigen::Vector2d line = inverse * right;
  Eigen::Matrix2d scores = Eigen::Matrix2d::Zero();
  for (const auto& [key, samples] : clusters) {
    Eigen::Vector2d score = Eigen::Vector2d::Zero();
    for (const Sample& sample : samples) score += sample.x * (sample.error_m - sample.x.dot(line));
    scores += score * score.transpose();
  }
  const Eigen::Matrix2d covariance =
      inverse * scores * inverse * (cluster_count / (cluster_count - 1.0));
  const double half =
      StudentQuantile975(cluster_count - 1.0) * std::sqrt(std::max(0.0, covariance(1, 1)));
  slope.m_per_mps = line(1);
  slope.low = line(1) - half;
  slope.high = line(1) + half;
  return slope;
}

std::vector<SpeedBin> ErrorsBySpeedDifference(std::span<const DriveOutcome> outcomes,
                                              std::size_t min_count) {
  struct Errors {
    std::vector<double> rte_m, rre_deg;
  };
  std::map<int, Errors> errors;
  for (const DriveOutcome& outcome : outcomes) {
    for (const ScanOutcome& scan : outcome.scans) {
      if (!IsSuccess(scan) || !scan.speed_difference_mps) continue;
      Errors& bin = errors[static_cast<int>(std::abs(*scan.speed_difference_mps) / kBin_mps)];
      bin.rte_m.push_back(scan.error.translation_m);
      bin.rre_deg.push_back(scan.error.rotation_deg);
    }
  }
  std::vector<SpeedBin> bins;
  for (const auto& [index, bin] : errors) {
    if (bin.rte_m.size() < min_count) continue;
    bins.push_back({.begin_mps = kBin_mps * index,
                    .end_mps = kBin_mps * (index + 1),
                    .count = bin.rte_m.size(),
                    .rte_mean_m = Mean(bin.rte_m),
                    .rte_median_m = Quantile(bin.rte_m, 0.5),
                    .rre_mean_deg = Mean(bin.rre_deg),
                    .rre_median_deg = Quantile(bin.rre_deg, 0.5)});
  }
  return bins;
}

}  // namespace dcloc::paper
