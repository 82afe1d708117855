#pragma once

#include "core/calibration/calibration.h"

namespace dcloc {

/// Fills in `applied` and `remaining_sigma` of all parameters from `correction`, `sigma`,
/// `prior_sigma` and `calibration.covariance`.
///
/// Corrections of one kind (all betas, all time offsets, ...) are their mean over the radars and
/// each radar's own deviation from it, since data often know the one and not the other: radars that
/// see one world compare their clocks with one another far better than with the poses' clock. The
/// mean is applied or left out, and so are all deviations together. Applied, a part leaves errors
/// of sigma^2; left out, of correction^2 - sigma^2 as far as the data tell. So it is applied if
/// correction^2 > 2 sigma^2; where the data hardly determine it (sigma >= prior_sigma / 2), only if
/// 0 lies outside of the 95 % interval.
void ChooseApplied(Calibration& calibration);

}  // namespace dcloc
