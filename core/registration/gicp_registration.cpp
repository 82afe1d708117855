#include "core/registration/gicp_registration.h"

namespace dcloc {

template <int Dim>
Registration<Dim> GicpRegistration<Dim>::Register(const RegistrationInput<Dim>& input,
                                                  RegistrationWorkspace<Dim>& workspace) const {
  GicpOptions options = options_;
  options.initial_blur_m = input.guess_sigma_m;
  if (input.effort) {
    options.max_iterations = input.effort->max_iterations;
    options.translation_tolerance_m = input.effort->translation_tolerance_m;
    options.rotation_tolerance_rad = input.effort->rotation_tolerance_rad;
  }
  return RegisterGicp<Dim>(input.points, input.map, input.T_local_vehicle_guess, options,
                           workspace.finder);
}

template class GicpRegistration<2>;
template class GicpRegistration<3>;

}  // namespace dcloc
