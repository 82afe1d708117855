#pragma once

#include "core/registration/gicp.h"
#include "core/registration/registration_method.h"

namespace dcloc {

/// Our registration method: uncertainty-aware GICP (METHOD eq 12-14).
template <int Dim>
class GicpRegistration final : public RegistrationMethod<Dim> {
 public:
  explicit GicpRegistration(const GicpOptions& options) : options_(options) {}

  Registration<Dim> Register(const RegistrationInput<Dim>& input,
                             RegistrationWorkspace<Dim>& workspace) const override;

  bool PreparesFinder() const override { return true; }

 private:
  GicpOptions options_;
};

}  // namespace dcloc
