#include <gtest/gtest.h>

#include "core/mapping/drive_tracker.h"
#include "core/mapping/scale_estimator.h"
#include "core/mapping/survey.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

TEST(MappingOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<DriveTrackerOptions>();
  ExpectEachFieldIsBounded<SubmapMatcherOptions>();
  ExpectEachFieldIsBounded<SurveyGraphSolverOptions>();
  ExpectEachFieldIsBounded<PairwiseConsistencyOptions>();
  ExpectEachFieldIsBounded<PathCosts>();
  ExpectEachFieldIsBounded<LoopFinderOptions>();
  ExpectEachFieldIsBounded<PlaceFinderOptions>();
  ExpectEachFieldIsBounded<ScaleEstimatorOptions>();
  ExpectEachFieldIsBounded<SurveyOptions>();
}

TEST(MappingOptionsTest, NamesThePartThatIsWrong) {
  SurveyOptions options;
  options.loops.matcher.candidate_count = 0;
  EXPECT_EQ(Validate(options).message(),
            "loops.matcher.candidate_count is 0; it must lie in [1, 100]");
}

}  // namespace
}  // namespace dcloc
