#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/session.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {

/// What a test decides about a scripted localizer, and what it sees of it.
struct LocalizerScript {
  LocalizationState state = LocalizationState::kTracking;
  absl::Status status;  ///< of the next scans
  bool has_pose = true;
  bool beta_is_wrong = false;
  Health health;
  PoseResets resets;
  absl::StatusOr<FixUse> fix_use = FixUse::kFused;
  std::vector<PositionFix> fixes;                        ///< of all localizers
  std::vector<std::optional<InitialPose>> created_with;  ///< one for each localizer
  std::vector<Scan> scans;                               ///< of all localizers
};

/// Puts the vehicle as far along x as the number of scans before.
class ScriptedLocalizer final : public ScanLocalizer {
 public:
  explicit ScriptedLocalizer(LocalizerScript& script) : script_(script) {}

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override {
    if (!script_.status.ok()) return script_.status;
    if (listener != nullptr) listener->OnStageBegin(Stage::kRegistration);
    Localization localization{.stamp = scan.stamp, .state = script_.state};
    localization.T_map_vehicle.translation_m.x() = static_cast<double>(script_.scans.size());
    localization.covariance = Matrix6d::Identity();
    localization.quality.beta.is_wrong = script_.beta_is_wrong;
    localization.health = script_.health;
    localization.resets = script_.resets;
    script_.scans.push_back(scan);
    return localization;
  }

  absl::StatusOr<FixUse> TakeFix(const PositionFix& fix) override {
    script_.fixes.push_back(fix);
    return script_.fix_use;
  }

  std::optional<LocalizerSnapshot> Snapshot() override { return std::nullopt; }
  absl::Status Restore(const LocalizerSnapshot& /*snapshot*/) override {
    return absl::UnimplementedError("it follows its script");
  }
  bool has_pose() const override { return script_.has_pose; }

 private:
  LocalizerScript& script_;
};

/// A session of one radar, "front", in a small map.
class SessionParts : public ::testing::Test {
 protected:
  static LoadedMap Map(std::int64_t version) {
    LoadedMap loaded{.record = {}, .map = *RadarMap::FromBytes(SmallMap())};
    loaded.record.version = version;
    return loaded;
  }

  SessionContext Context() {
    return {.pool = pool_,
            .totals = totals_,
            .metrics = metrics_,
            .create_localizer =
                [this](const std::shared_ptr<const RadarMap>&, const Rig&,
                       const std::optional<InitialPose>& pose,
                       const LocalizerOptions&) -> absl::StatusOr<std::unique_ptr<ScanLocalizer>> {
              if (!create_status_.ok()) return create_status_;
              script_.created_with.push_back(pose);
              return std::make_unique<ScriptedLocalizer>(script_);
            },
            .answer_history_count = 4,
            .detached_timeout = std::chrono::minutes(1),
            .tickets = nullptr};
  }

  std::shared_ptr<Session> MakeSession(std::optional<InitialPose> initial_pose = std::nullopt) {
    auto info = std::make_shared<SessionInfo>();
    info->description.session_id = "session";
    info->description.resume_token = "secret";
    info->description.caller.permit = *usages_.TakeSession({});
    info->map_version = 1;
    auto session = Session::Create(Context(), {.info = std::move(info),
                                               .map = Map(1),
                                               .rig = convert::FromProto(OpenMessage())->rig,
                                               .options = {},
                                               .initial_pose = std::move(initial_pose)});
    EXPECT_TRUE(session.ok()) << session.status();
    return *std::move(session);
  }

  static ScanAnswer Answer(Session& session, const v1::Scan& scan) {
    std::optional<ScanAnswer> copy;
    session.Answer(scan, Arrival::Now(), [&](const ScanAnswer& answer) { copy = answer; });
    return copy.value();
  }

  static FixAnswer TakeFix(Session& session, const v1::PositionFix& fix) {
    std::optional<FixAnswer> copy;
    session.TakeFix(fix, [&](const FixAnswer& answer) { copy = answer; });
    return copy.value();
  }

  static ScanAnswer AnswerDropped(Session& session, std::int64_t sequence_number) {
    std::optional<ScanAnswer> copy;
    session.AnswerDropped(sequence_number, [&](const ScanAnswer& answer) { copy = answer; });
    return copy.value();
  }

  ServerConfig config_;
  Limits limits_{config_};
  UsageCounts usages_{limits_};
  WorkerPool pool_{1, 1};
  ScanCounts totals_;
  SessionMetrics metrics_;
  LocalizerScript script_;
  absl::Status create_status_;
};

}  // namespace dcloc::server
