#pragma once

#include <memory>
#include <utility>

#include "client/evaluation/baselines/planar_registration.h"
#include "core/registration/gicp.h"
#include "core/registration/registration_method.h"

namespace dcloc {

/// Another registration algorithm behind core's `RegistrationMethod`. The pose is its own.
/// Covariance, inliers and residuals, which it does not provide, are computed at that pose as for
/// our method.
class MethodInLocalizer final : public RegistrationMethod<2> {
 public:
  MethodInLocalizer(std::unique_ptr<PlanarRegistration> registration, const GicpOptions& judge)
      : registration_(std::move(registration)), judge_(judge) {
    judge_.max_iterations = 0;
  }

  /// Where the method finds nothing, the result has not converged and has no inlier.
  Registration<2> Register(const RegistrationInput<2>& input,
                           RegistrationWorkspace<2>& workspace) const override;

 private:
  std::unique_ptr<PlanarRegistration> registration_;
  GicpOptions judge_;
};

}  // namespace dcloc
