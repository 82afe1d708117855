#pragma once

#include <memory>

#include "client/evaluation/baselines/matcher.h"

namespace dcloc {

/// Point-to-point ICP of the Point Cloud Library, twice: with a wide reach, then with a narrow one.
std::unique_ptr<Matcher> MakeIcpMatcher();

/// Grid-based normal distributions transform in the plane (Biber and Strasser) of the Point Cloud
/// Library. Landmarks are drawn out to their covariances, so that a cell's distribution is that of
/// the returns rather than of their means.
std::unique_ptr<Matcher> MakeNdtMatcher();

}  // namespace dcloc
