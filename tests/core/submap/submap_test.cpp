#include "core/submap/submap.h"

#include <gtest/gtest.h>

#include <random>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

Stamp At(int ms) { return Stamp(milliseconds(ms)); }

Motion Step() {
  Vector6d xi;
  xi << 1.0, 0.05, 0.0, 0.0, 0.0, 0.03;
  Motion motion{.T_from_to = Exp(xi)};
  Vector6d sigmas;
  sigmas << 0.05, 0.03, 0.01, 0.002, 0.002, 0.01;
  motion.covariance = sigmas.cwiseAbs2().asDiagonal();
  return motion;
}

RadarPoint PointAt(const Eigen::Vector3d& p) {
  return {.position_m = p, .covariance_m2 = 0.04 * Eigen::Matrix3d::Identity()};
}

// Points are kept in single precision: half a step of it at 30 m.
constexpr double kSinglePrecision_m = 2e-6;

TEST(SubmapTest, AStandingPointFallsOntoItselfInTheNewestFrame) {
  // The printed product of eq 8 and both orders of inverse steps fail this.
  const Eigen::Vector3d p_first(30.0, -7.0, 1.0);
  SubmapWindow window(10);
  Pose3 T_first_now;
  for (int i = 0; i < 10; ++i) {
    if (i > 0) T_first_now = T_first_now * Step().T_from_to;
    window.Push(At(75 * i), 0, {PointAt(T_first_now.Inverse() * p_first)}, Step());
  }
  const Submap submap = window.Join(DriftCovariance::kAdded);
  ASSERT_EQ(submap.points.size(), 10U);
  EXPECT_EQ(submap.span, milliseconds(675));
  for (const RadarPoint& point : submap.points) {
    EXPECT_LT((point.position_m - T_first_now.Inverse() * p_first).norm(), kSinglePrecision_m);
  }
}

TEST(SubmapTest, KeepsTheLastScansOfEachRadar) {
  SubmapWindow window(2);
  Pose3 T_first_now;
  const Eigen::Vector3d p_first(20.0, 0.0, 0.0);
  const int radars[] = {0, 1, 0, 0, 1, 0};
  for (int i = 0; i < 6; ++i) {
    if (i > 0) T_first_now = T_first_now * Step().T_from_to;
    window.Push(At(10 * i), radars[i], {PointAt(T_first_now.Inverse() * p_first)}, Step());
  }
  const Submap submap = window.Join(DriftCovariance::kLeftOut);
  EXPECT_EQ(submap.scan_count, 4);  // scans 1 and 4 of radar 1, 3 and 5 of radar 0
  EXPECT_EQ(submap.span, milliseconds(40));
  for (const RadarPoint& point : submap.points) {  // also across the removed scan's way
    EXPECT_LT((point.position_m - T_first_now.Inverse() * p_first).norm(), kSinglePrecision_m);
  }
}

// The scans of a drive, of which some come late.
TEST(SubmapTest, AScanThatComesLateLiesWhereItWasTaken) {
  const Eigen::Vector3d p_first(20.0, 3.0, 0.0);
  const auto seen_at = [&](double steps) {
    const Pose3 T_first_now = Exp(Vector6d(steps * Log(Step().T_from_to)));
    return std::vector<RadarPoint>{PointAt(T_first_now.Inverse() * p_first)};
  };
  SubmapWindow window(10);
  for (int i = 0; i < 4; ++i) window.Push(At(100 * i), 0, seen_at(i), Step());
  EXPECT_TRUE(window.Insert(At(150), 1, seen_at(1.5)));
  EXPECT_TRUE(window.Insert(At(100), 1, seen_at(1.0)));
  EXPECT_TRUE(window.Insert(At(300), 1, seen_at(3.0)));
  EXPECT_FALSE(window.Insert(At(-10), 1, seen_at(0.0))) << "before all";
  const Submap submap = window.Join(DriftCovariance::kAdded);
  EXPECT_EQ(submap.scan_count, 7);
  EXPECT_EQ(submap.span, milliseconds(300));
  const Pose3 T_first_newest = Exp(Vector6d(3.0 * Log(Step().T_from_to)));
  for (const RadarPoint& point : submap.points) {
    EXPECT_LT((point.position_m - T_first_newest.Inverse() * p_first).norm(), kSinglePrecision_m);
  }
}

TEST(SubmapTest, ALateScanTakesTheRoomOfItsRadarsOldest) {
  SubmapWindow window(2);
  for (int i = 0; i < 3; ++i) window.Push(At(100 * i), 0, {PointAt({1.0, 0.0, 0.0})}, Step());
  EXPECT_TRUE(window.Insert(At(150), 0, {PointAt({1.0, 0.0, 0.0})}));
  EXPECT_EQ(window.scan_count(), 2);
  window.Push(At(300), 1, {PointAt({1.0, 0.0, 0.0})}, Step());
  EXPECT_FALSE(window.Insert(At(140), 0, {PointAt({9.0, 0.0, 0.0})})) << "it is the oldest";
  EXPECT_EQ(window.scan_count(), 3);
  for (const RadarPoint& point : window.Join(DriftCovariance::kLeftOut).points) {
    EXPECT_LT(point.position_m.x(), 5.0);
  }
  SubmapWindow single(1);
  single.Push(At(0), 0, {PointAt({1.0, 0.0, 0.0})}, Step());
  single.Insert(At(0), 0, {PointAt({1.0, 0.0, 0.0})});
  EXPECT_LE(single.scan_count(), 1);
}

TEST(SubmapTest, ScansOfASilentRadarGrowTooOld) {
  SubmapWindow window(10, {.max_age = milliseconds(1000)});
  window.Push(At(0), 1, {PointAt({1.0, 0.0, 0.0})}, Step());
  for (int i = 1; i < 30; ++i) window.Push(At(100 * i), 0, {PointAt({1.0, 0.0, 0.0})}, Step());
  EXPECT_EQ(window.scan_count(), 10);
  EXPECT_EQ(window.span(), milliseconds(900));
}

TEST(SubmapTest, AScanOfManyPointsIsThinned) {
  SubmapWindow window(10, {.max_scan_points = 100});
  window.Push(At(0), 0, std::vector<RadarPoint>(20'000, PointAt({1.0, 0.0, 0.0})), Step());
  EXPECT_EQ(window.point_count(), 100U);
}

TEST(SubmapTest, SaysWhichPointsAreOfWhichScan) {
  SubmapWindow window(2);
  for (int i = 0; i < 3; ++i) {
    const std::vector<RadarPoint> points(static_cast<std::size_t>(3 + i),
                                         PointAt({20.0, 0.0, 0.0}));
    window.Push(At(10 * i), i % 2, points, Step());
  }
  LiveSubmap<2> submap;
  window.Join(DriftCovariance::kAdded, 5, submap);  // every third of twelve
  ASSERT_EQ(submap.points.size(), 4U);
  ASSERT_EQ(submap.parts.size(), 3U);
  std::size_t end = 0;
  Pose3 T_newest_then;
  for (int i = 0; i < 3; ++i) {
    const auto& part = submap.parts[static_cast<std::size_t>(i)];
    EXPECT_EQ(part.radar_index, i % 2);
    EXPECT_LT(Log(part.T_newest_then.Inverse() * T_newest_then).norm(), 1e-12);
    EXPECT_EQ(part.begin, end);
    end = part.end;
    T_newest_then = Step().T_from_to.Inverse() * T_newest_then;
  }
  EXPECT_EQ(end, submap.points.size());
}

TEST(SubmapTest, DriftWidensOldPointsAsSampledMotionsDo) {
  const Eigen::Vector3d p_then(40.0, 10.0, 0.0);
  SubmapWindow window(4);
  window.Push(At(0), 0, {PointAt(p_then)}, {});
  for (int i = 1; i < 4; ++i) window.Push(At(75 * i), 0, {}, Step());
  const Submap submap = window.Join(DriftCovariance::kAdded);
  ASSERT_EQ(submap.points.size(), 1U);

  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d sampled = 0.04 * Eigen::Matrix3d::Identity();
  const Vector6d sigmas = Step().covariance.diagonal().cwiseSqrt();
  constexpr int kRuns = 20'000;
  for (int run = 0; run < kRuns; ++run) {
    Pose3 T_then_now;
    for (int i = 0; i < 3; ++i) {
      Vector6d error;
      for (int k = 0; k < 6; ++k) error(k) = sigmas(k) * normal(random);
      T_then_now = T_then_now * Step().T_from_to * Exp(error);
    }
    const Eigen::Vector3d d = T_then_now.Inverse() * p_then - submap.points[0].position_m;
    sampled += d * d.transpose() / kRuns;
  }
  EXPECT_LT((submap.points[0].covariance_m2 - sampled).norm(), 0.05 * sampled.norm());
  EXPECT_LT(window.Join(DriftCovariance::kLeftOut).points[0].covariance_m2.norm(), 0.08);
}

template <int Dim>
void ExpectSameForMatching(const SubmapWindow& window) {
  const Submap submap = window.Join(DriftCovariance::kAdded);
  LiveSubmap<Dim> live{.points = std::vector<GaussianPoint<Dim>>(3), .parts = {}};
  window.Join<Dim>(DriftCovariance::kAdded, 1000, live);  // replaces what was there
  const std::vector<GaussianPoint<Dim>>& points = live.points;
  ASSERT_EQ(points.size(), submap.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RadarPoint& whole = submap.points[i];
    EXPECT_LT((points[i].mean_m - whole.position_m.head<Dim>()).norm(), 1e-12);
    const auto part = whole.covariance_m2.topLeftCorner<Dim, Dim>();
    EXPECT_LT((points[i].covariance_m2 - part).norm(), 1e-12);
    if constexpr (Dim == 2) {
      EXPECT_LT((points[i].slant_per_m - whole.slant_per_m).norm(), 1e-12);
    } else {
      EXPECT_EQ(points[i].slant_per_m.norm(), 0.0) << "in space heights are measured";
    }
  }
  LiveSubmap<Dim> few;
  window.Join<Dim>(DriftCovariance::kAdded, 4, few);
  ASSERT_EQ(few.points.size(), 4U) << "every third of twelve";
  EXPECT_EQ(few.points[1].mean_m, points[3].mean_m);
}

TEST(SubmapTest, WhatAHeightMovesAPointByTurnsWithTheVehicle) {
  SubmapWindow window(4);
  RadarPoint point = PointAt({20.0, 0.0, 0.0});
  point.slant_per_m = {0.025, 0.0};
  window.Push(At(0), 0, {point}, {});
  Motion turn;
  turn.T_from_to = Embed(Pose2{.translation_m = {}, .yaw_rad = 0.5});
  window.Push(At(75), 0, {}, turn);
  const Submap submap = window.Join(DriftCovariance::kLeftOut);
  ASSERT_EQ(submap.points.size(), 1U);
  const Eigen::Vector2d truth = 0.025 * Eigen::Vector2d(std::cos(0.5), -std::sin(0.5));
  EXPECT_LT((submap.points[0].slant_per_m - truth).norm(), 1e-7);
}

TEST(SubmapTest, ForMatchingItIsTheSamePointsInThePlaneOrInSpace) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place_m(-50.0, 50.0);
  SubmapWindow window(4);
  for (int i = 0; i < 4; ++i) {
    std::vector<RadarPoint> points;
    for (int k = 0; k < 3; ++k) {
      points.push_back(PointAt({place_m(random), place_m(random), 0.1 * place_m(random)}));
      points.back().slant_per_m = {0.01, 0.001 * k};
      points.back().covariance_m2(0, 1) = points.back().covariance_m2(1, 0) = 0.01;
      points.back().covariance_m2(1, 2) = points.back().covariance_m2(2, 1) = -0.02;
    }
    window.Push(At(75 * i), 0, points, Step());
  }
  EXPECT_EQ(window.point_count(), 12U);
  EXPECT_EQ(window.scan_count(), 4);
  EXPECT_EQ(window.span(), milliseconds(225));
  ExpectSameForMatching<2>(window);
  ExpectSameForMatching<3>(window);
}

}  // namespace
}  // namespace dcloc
