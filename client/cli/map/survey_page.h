#pragma once

#include <string>

#include "core/mapping/survey_builder.h"

namespace dcloc::cli {

/// A page on a survey: where the drives went, by ego-motion alone and as the loops put them, with
/// every loop and what was left out, and what is wrong with the radars.
std::string SurveyHtml(const SurveyBuilder& builder);

}  // namespace dcloc::cli
