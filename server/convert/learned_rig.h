#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/odometry/rig_knowledge.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server::convert {

/// InvalidArgument names the field under `field`, the value and the bound.
absl::StatusOr<RigKnowledge> FromProto(const v1::LearnedRig& message, absl::string_view field);

/// Sets every field, so that nothing of what `message` held before shows through.
void ToProto(const RigKnowledge& known, v1::LearnedRig* message);

}  // namespace dcloc::server::convert
