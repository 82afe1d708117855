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

/// "slip", "mount", ...
std::string FaultText(v1::SourceFault fault);

/// "fused", "contradicted", ...
std::string UseText(v1::FixUse use);

/// The sources that are set aside, as "radar front (mount), wheel speed (slip)"; empty when none
/// is. Sources that say nothing are not named.
std::string SetAsideText(const v1::Health& health);

/// An answer as a line of text: number, state, position, heading, deviations, protection level,
/// time, and the sources set aside; or what became of a position fix.
std::string AnswerLine(const v1::LocalizeResponse& answer);

/// The same for scripts.
nlohmann::ordered_json AnswerJson(const v1::LocalizeResponse& answer);

/// Each source with whether it is used, and its fault.
nlohmann::ordered_json HealthJson(const v1::Health& health);

nlohmann::ordered_json SessionJson(const v1::Session& session);

}  // namespace dcloc::cli
