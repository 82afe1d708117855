#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/odometry/rig_knowledge.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::cli {

v1::LearnedRig ToProto(const RigKnowledge& known);

/// As it stands; the server checks it.
RigKnowledge FromProto(const v1::LearnedRig& message);

/// What an earlier session kept in `path`, as JSON; nothing where there is no such file. Errors
/// name the file and what is wrong with it.
absl::StatusOr<std::optional<v1::LearnedRig>> ReadLearnedRig(const std::string& path);

/// Keeps it there for the next session, in place of what the file held.
absl::Status WriteLearnedRig(const std::string& path, const v1::LearnedRig& message);

/// A line for each thing that was learned, for people.
std::string LearnedRigText(const v1::LearnedRig& message);

}  // namespace dcloc::cli
