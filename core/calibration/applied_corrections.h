#pragma once

#include "core/calibration/calibration.h"

namespace dcloc {

/// Fills in `applied` and `remaining_sigma` of all parameters from `correction`, `sigma`,
/// `prior_sigma` and `calibration.covariance`.
///
/// Corrections of one kind (all betas, all time offsets, ...) are split into their mean over the
/// radars and each radar's deviation from it. Data often determine only one of the two: radars are
/// compared with each other far better than with the clock of the poses. The mean is either applied
/// or left out; so are all deviations together. If a part is applied, the expected squared error is
/// sigma^2; if it is left out, correction^2 - sigma^2. So it is applied if correction^2 > 2
/// sigma^2. If the data hardly determine it (sigma >= prior_sigma / 2), it is applied only if 0
/// lies outside of the 95 % interval.
///
/// Where `poses_are_own`, of the same radars as they are described, the mean of the time offsets is
/// left out: poses lie where radars were, whatever their clock said then. Poses also follow other
/// errors in part, so what is applied is to lie outside of the 95 % interval.
void ChooseApplied(Calibration& calibration, bool poses_are_own = false);

}  // namespace dcloc
