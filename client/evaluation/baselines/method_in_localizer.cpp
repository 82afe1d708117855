#include "client/evaluation/baselines/method_in_localizer.h"

namespace dcloc {

Registration<2> MethodInLocalizer::Register(const RegistrationInput<2>& input,
                                            RegistrationWorkspace<2>& workspace) const {
  constexpr std::uint64_t kSeed = 1;  // the same input gives the same result
  const std::optional<PlanarFit> fit =
      registration_->Register(input.points, input.map, input.T_local_vehicle_guess, kSeed);
  if (!fit) {
    return {.T_local_vehicle = input.T_local_vehicle_guess,
            .covariance = kUnobserved * TangentMatrix<2>::Identity()};
  }
  Registration<2> result =
      RegisterGicp<2>(input.points, input.map, fit->T_local_vehicle, judge_, workspace.finder);
  if (fit->covariance) result.covariance = *fit->covariance;
  result.converged = true;
  return result;
}

}  // namespace dcloc
