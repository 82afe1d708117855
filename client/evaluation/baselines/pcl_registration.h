#pragma once

#include <memory>

#include "client/evaluation/baselines/planar_registration.h"

namespace dcloc {

/// From now on the Point Cloud Library says nothing on stderr: what finds no cell with enough
/// points is no match. For the whole program, so before it has a second thread.
void SilencePcl();

/// Point-to-point ICP of the Point Cloud Library, twice: with a wide reach, then with a narrow one.
std::unique_ptr<PlanarRegistration> MakeIcpRegistration();

/// Generalized ICP of the Point Cloud Library, whose covariances come from neighbouring points.
std::unique_ptr<PlanarRegistration> MakePclGicpRegistration();

/// Grid-based normal distributions transform in the plane (Biber and Strasser) of the Point Cloud
/// Library. Landmarks are drawn out to their covariances, so that a cell's distribution is that of
/// the returns rather than of their means.
std::unique_ptr<PlanarRegistration> MakeNdtRegistration();

}  // namespace dcloc
