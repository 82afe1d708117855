#pragma once

#include "client/evaluation/faults/protection_level.h"
#include "client/evaluation/gnuplot.h"

namespace dcloc::faults {

/// A Stanford diagram: errors across, protection levels up, both logarithmic, coloured by the
/// number of answers. What lies below the diagonal was not protected. The histogram has answers.
Picture StanfordPicture(const StanfordHistogram& histogram);

}  // namespace dcloc::faults
