#include "client/sdk/session.h"

#include <utility>

#include "client/sdk/session_engine.h"

namespace dcloc::client {

absl::StatusOr<std::unique_ptr<Session>> Session::Connect(const ChannelOptions& server,
                                                          v1::OpenSession open,
                                                          const SessionOptions& options) {
  const auto channel = MakeChannel(server);
  if (!channel.ok()) return channel.status();
  return Open(*channel, std::move(open), options);
}

absl::StatusOr<std::unique_ptr<Session>> Session::Open(
    const std::shared_ptr<grpc::Channel>& channel, v1::OpenSession open,
    const SessionOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  auto engine = std::make_unique<SessionEngine>(v1::LocalizationService::NewStub(channel),
                                                std::move(open), options);
  if (absl::Status status = engine->WaitUntilOpen(); !status.ok()) return status;
  if (!options.record_file.empty()) {
    if (absl::Status status = engine->StartRecording(); !status.ok()) return status;
  }
  return std::unique_ptr<Session>(new Session(std::move(engine)));
}

Session::Session(std::unique_ptr<SessionEngine> engine) : engine_(std::move(engine)) {}
Session::~Session() = default;

const v1::SessionOpened& Session::opened() const { return engine_->opened(); }
absl::Status Session::Send(v1::Scan scan) {
  return engine_->Send(std::move(scan), ScanNumber::kGiven);
}
absl::Status Session::SendTargets(const std::string& radar_id, std::int64_t stamp_ns,
                                  std::span<const Target> targets) {
  return engine_->Send(ScanOf(radar_id, stamp_ns, targets), ScanNumber::kNext);
}
absl::Status Session::SendFix(v1::PositionFix fix) { return engine_->SendFix(std::move(fix)); }
void Session::CloseSending() { engine_->CloseSending(); }
std::optional<v1::LocalizeResponse> Session::Next() { return engine_->Next(); }
absl::Status Session::AddMotion(const MotionTick& tick) { return engine_->AddMotion(tick); }
absl::Status Session::AddEgoVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity) {
  return engine_->poses().AddVelocity(stamp_ns, velocity);
}
absl::StatusOr<PoseEstimate> Session::PoseAt(std::int64_t stamp_ns) const {
  return engine_->poses().PoseAt(stamp_ns);
}
absl::StatusOr<PoseEstimate> Session::SmoothPoseAt(std::int64_t stamp_ns) const {
  return engine_->poses().SmoothPoseAt(stamp_ns);
}
void Session::Cancel() { engine_->Cancel(); }
absl::Status Session::EndStatus() const { return engine_->EndStatus(); }
absl::Status Session::record_status() const { return engine_->record_status(); }
SessionStats Session::stats() const { return engine_->stats(); }

}  // namespace dcloc::client
