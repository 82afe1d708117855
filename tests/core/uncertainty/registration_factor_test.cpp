#include "core/uncertainty/registration_factor.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr RegistrationFactorOptions kFactorOptions{
    .shared_sigma_m = 0.1, .shared_sigma_rad = 0.01, .shared_time = milliseconds(3000)};

Registration<2> Registered(double residual_scale) {
  Registration<2> registration;
  registration.T_local_vehicle = {.translation_m = {1.0, 2.0}, .yaw_rad = 0.3};
  registration.covariance = 1e-4 * TangentMatrix<2>::Identity();
  registration.residual_scale = residual_scale;
  return registration;
}

AbsolutePoseFactor<2> Edge(const RegistrationTiming& timing, double residual_scale = 1.0) {
  const Registration<2> registration = Registered(residual_scale);
  return RegistrationFactor<2>(registration, TangentMatrix<2>::Zero(),
                               ResidualScaledCovariance<2>(registration),
                               4e-6 * TangentMatrix<2>::Identity(), timing, kFactorOptions);
}

RegistrationTiming At(double speed_mps, int count) {
  return {.interval = milliseconds(100),
          .submap_span = milliseconds(900),
          .speed_mps = speed_mps,
          .count = count};
}

TEST(RegistrationFactorTest, TheFirstSharesNothing) {
  const AbsolutePoseFactor<2> edge = Edge(At(10.0, 1));
  EXPECT_DOUBLE_EQ(edge.covariance(0, 0), 1e-4 + 0.01);
  EXPECT_DOUBLE_EQ(edge.covariance(2, 2), 1e-4 + 1e-4);
  EXPECT_TRUE(edge.weight_covariance.isApprox(edge.covariance));
  EXPECT_EQ(edge.pose.yaw_rad, 0.3);
}

TEST(RegistrationFactorTest, ScansAreDividedAmongTheRegistrationsThatTheyAreIn) {
  // Ten registrations while a scan is in the sub-map, 31 while errors are shared.
  const AbsolutePoseFactor<2> edge = Edge(At(10.0, 1000));
  EXPECT_NEAR(edge.weight_covariance(0, 0), 10.0 * 1e-4 + 31.0 * 0.01, 1e-12);
}

// 50 m of landmarks: 5 s at 10 m/s, of which 0.15 are theirs, beside the scans' ten.
TEST(RegistrationFactorTest, LandmarksAreSharedForTheWayThatTheyAreSeen) {
  EXPECT_NEAR((*Edge(At(10.0, 1000)).noise_covariance)(0, 0), (10.0 + 0.15 * 51.0) * 1e-4, 1e-9);
  EXPECT_NEAR((*Edge(At(25.0, 1000)).noise_covariance)(0, 0), (10.0 + 0.15 * 21.0) * 1e-4, 1e-9);
  // Standing, for no longer than ten seconds.
  EXPECT_NEAR((*Edge(At(0.0, 1000)).noise_covariance)(0, 0), (10.0 + 0.15 * 101.0) * 1e-4, 1e-9);
}

TEST(RegistrationFactorTest, ResidualsWidenTheWeightAndDoNotNarrowIt) {
  EXPECT_DOUBLE_EQ(Edge(At(10.0, 1), 1.5).covariance(0, 0), 2.25e-4 + 0.01);
  EXPECT_DOUBLE_EQ(Edge(At(10.0, 1), 0.5).covariance(0, 0), 1e-4 + 0.01);
  EXPECT_NEAR((*Edge(At(10.0, 1), 0.5).noise_covariance)(0, 0), 1.15 * 0.25e-4, 1e-12);
}

TEST(RegistrationFactorTest, LastingErrorsAreASquareRoot) {
  const TangentMatrix<2> systematic = Edge(At(10.0, 1)).systematic;
  EXPECT_TRUE(
      (systematic * systematic.transpose()).isApprox(4e-6 * TangentMatrix<2>::Identity(), 1e-3));
}

}  // namespace
}  // namespace dcloc
