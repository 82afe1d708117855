#include "core/odometry/source_diagnosis.h"

#include <gtest/gtest.h>

#include <functional>

namespace dcloc {
namespace {

// A vehicle that goes faster and faster, and what a source says of it.
SourceFault FaultOf(const std::function<double(double moved_mps, int i)>& said) {
  SourceDiagnosis diagnosis(0.5);
  for (int i = 0; i < 12; ++i) {
    const double moved_mps = 8.0 + 0.3 * i;
    diagnosis.OnReading(said(moved_mps, i), moved_mps);
  }
  return diagnosis.fault();
}

TEST(SourceDiagnosisTest, NamesWhatIsWrong) {
  EXPECT_EQ(FaultOf([](double, int) { return 0.0; }), SourceFault::kStanding);
  EXPECT_EQ(FaultOf([](double, int) { return 7.3; }), SourceFault::kFrozen);
  EXPECT_EQ(FaultOf([](double mps, int) { return -mps; }), SourceFault::kSign);
  EXPECT_EQ(FaultOf([](double mps, int) { return 1.3 * mps; }), SourceFault::kScale);
  EXPECT_EQ(FaultOf([](double mps, int i) { return mps + 3.0 + 0.1 * (i % 2); }),
            SourceFault::kScale);
  EXPECT_EQ(FaultOf([](double mps, int i) { return mps + 2.0 * i; }), SourceFault::kSlip);
}

TEST(SourceDiagnosisTest, AConstantDifferenceOfAVehicleThatStandsIsABias) {
  SourceDiagnosis diagnosis(0.02);
  for (int i = 0; i < 12; ++i) diagnosis.OnReading(0.05 + 0.001 * (i % 3), 0.001 * (i % 2));
  EXPECT_EQ(diagnosis.fault(), SourceFault::kBias);
}

TEST(SourceDiagnosisTest, OldReadingsAreForgotten) {
  SourceDiagnosis diagnosis(0.5);
  for (int i = 0; i < 20; ++i) diagnosis.OnReading(9.0 + 5.0 * (i % 2), 9.0);
  EXPECT_EQ(diagnosis.fault(), SourceFault::kSlip);
  for (int i = 0; i < 8; ++i) diagnosis.OnReading(0.0, 9.0);
  EXPECT_EQ(diagnosis.fault(), SourceFault::kStanding);
  diagnosis.Clear();
  EXPECT_EQ(diagnosis.fault(), SourceFault::kSlip);
}

}  // namespace
}  // namespace dcloc
