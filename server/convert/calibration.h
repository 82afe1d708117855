#pragma once

#include "core/calibration/calibration.h"
#include "dcloc/v1/map_service.pb.h"

namespace dcloc::server::convert {

void ToProto(const RadarCalibration& radar, v1::SurveyedRadar* message);

}  // namespace dcloc::server::convert
