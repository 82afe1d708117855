#pragma once

#include <span>
#include <string>

#include "core/mapping/drive_track.h"
#include "core/mapping/survey.h"

namespace dcloc::cli {

/// A page on a survey: where the drives went, by ego-motion alone and as the loops put them, with
/// every loop and what was left out.
std::string SurveyHtml(std::span<const DriveTrack> tracks, const Survey& survey);

}  // namespace dcloc::cli
