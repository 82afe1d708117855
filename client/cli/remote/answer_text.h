#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "dcloc/v1/admin_service.pb.h"

namespace dcloc::cli {

/// "tracking", "dead_reckoning", ...; "-" for none.
std::string StateText(v1::LocalizationState state);

/// "2026-01-31T12:00:00Z".
std::string TimeText(const google::protobuf::Timestamp& time);

/// "950 ms", "12 s", "3 min", "5 h".
std::string AgeText(double age_s);

/// An answer as a line of text: number, state, position, heading, deviations, time.
std::string AnswerLine(const v1::LocalizeResponse& answer);

/// The same for scripts.
nlohmann::ordered_json AnswerJson(const v1::LocalizeResponse& answer);

nlohmann::ordered_json SessionJson(const v1::Session& session);

}  // namespace dcloc::cli
