#include "client/ros/vehicle_link.h"

#include <utility>

namespace dcloc::node {

using Phase = LinkStatus::Phase;

VehicleLink::VehicleLink(std::shared_ptr<grpc::Channel> channel, client::SessionOptions options,
                         std::chrono::milliseconds retry_after, OnAnswer on_answer)
    : channel_(std::move(channel)),
      options_(std::move(options)),
      retry_after_(retry_after),
      on_answer_(std::move(on_answer)) {
  options_.on_event = [this](const client::SessionEvent& event) { OnEvent(event); };
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

VehicleLink::~VehicleLink() {
  thread_.request_stop();
  if (const auto open = session(); open != nullptr) open->Cancel();
  thread_.join();
}

void VehicleLink::Open(v1::OpenSession open) {
  {
    const std::lock_guard lock(mutex_);
    // The pose may have come first.
    if (open_ && open_->has_initial_pose()) {
      *open.mutable_initial_pose() = open_->initial_pose();
    }
    open_ = std::move(open);
    if (status_.phase == Phase::kWaiting) status_.phase = Phase::kConnecting;
  }
  changed_.notify_all();
}

void VehicleLink::SetInitialPose(const v1::PoseWithCovariance& pose) {
  const std::lock_guard lock(mutex_);
  if (!open_) open_.emplace();
  *open_->mutable_initial_pose() = pose;
}

std::shared_ptr<client::Session> VehicleLink::session() const {
  const std::lock_guard lock(mutex_);
  return session_;
}

absl::Status VehicleLink::Send(v1::Scan scan) {
  const auto open = session();
  return open == nullptr ? absl::UnavailableError("no session is open")
                         : open->Send(std::move(scan));
}

absl::Status VehicleLink::SendFix(v1::PositionFix fix) {
  const auto open = session();
  return open == nullptr ? absl::UnavailableError("no session is open")
                         : open->SendFix(std::move(fix));
}

void VehicleLink::AddVelocity(std::int64_t stamp_ns, const v1::EgoVelocity& velocity) {
  // An invalid one is reported with the scan that it belongs to.
  if (const auto open = session()) open->AddEgoVelocity(stamp_ns, velocity).IgnoreError();
}

absl::StatusOr<client::PoseEstimate> VehicleLink::SmoothPoseAt(std::int64_t stamp_ns) const {
  const auto open = session();
  if (open == nullptr) return absl::UnavailableError("no session is open");
  return open->SmoothPoseAt(stamp_ns);
}

LinkStatus VehicleLink::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void VehicleLink::Run(const std::stop_token& stop) {
  while (true) {
    std::optional<v1::OpenSession> open;
    {
      std::unique_lock lock(mutex_);
      const auto may_open = [this] { return status_.phase == Phase::kConnecting; };
      if (!changed_.wait(lock, stop, may_open)) return;
      open = open_;
    }
    RunSession(*open, stop);
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop, retry_after_, [] { return false; });
    if (stop.stop_requested()) return;
  }
}

/// Opens a session and hands on its answers until it ends.
void VehicleLink::RunSession(const v1::OpenSession& open, const std::stop_token& stop) {
  auto opened = client::Session::Open(channel_, open, options_);
  std::shared_ptr<client::Session> session;
  {
    const std::lock_guard lock(mutex_);
    if (!opened.ok()) {
      status_.text = std::string(opened.status().message());
      return;
    }
    session = *std::move(opened);
    session_ = session;
    open_->clear_initial_pose();  // where the vehicle has been, later sessions do not begin
    status_.phase = Phase::kOpen;
    status_.text.clear();
    status_.session_id = session->opened().session_id();
    status_.map_version = session->opened().map_version();
    ++status_.session_count;
  }
  if (stop.stop_requested()) session->Cancel();
  while (const auto answer = session->Next()) on_answer_(*answer);
  const std::lock_guard lock(mutex_);
  status_.text = std::string(session->EndStatus().message());
  status_.phase = Phase::kConnecting;
  session_.reset();
}

void VehicleLink::OnEvent(const client::SessionEvent& event) {
  using Kind = client::SessionEvent::Kind;
  const std::lock_guard lock(mutex_);
  status_.text = std::string(event.status.message());
  if (event.kind == Kind::kDisconnected) {
    ++status_.disconnect_count;
    status_.phase = Phase::kReconnecting;
  } else if (event.kind != Kind::kMoving) {
    status_.phase = Phase::kOpen;
    status_.session_id = event.opened.session_id();
    status_.map_version = event.opened.map_version();
  }
}

}  // namespace dcloc::node
