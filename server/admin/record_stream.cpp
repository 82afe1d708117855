#include "server/admin/record_stream.h"

#include "absl/strings/str_cat.h"
#include "server/convert/time.h"

namespace dcloc::server {

std::shared_ptr<void> RecordingSlots::Take(int max) {
  if (taken_->fetch_add(1) >= max) {
    taken_->fetch_sub(1);
    return nullptr;
  }
  return {taken_.get(), [taken = taken_](void*) { taken->fetch_sub(1); }};
}

std::shared_ptr<RecordStream> RecordStream::Start(const RpcContext& host,
                                                  grpc::CallbackServerContext* context,
                                                  std::string program) {
  return Hold(std::shared_ptr<RecordStream>(new RecordStream(host, context, std::move(program))));
}

void RecordStream::Begin(const absl::Status& status, std::shared_ptr<void> slot) {
  {
    const std::lock_guard lock(mutex_);
    slot_ = std::move(slot);
  }
  BeginWith(status);
}

void RecordStream::OnRelayed(int place, v1::RecordSessionResponse message) {
  if (election_->Take(place)) Push(std::move(message));
}

// Where nobody is first yet, the vehicle's next session would open there unseen.
void RecordStream::OnRelayEnd(int place, const std::string& address, const grpc::Status& status) {
  if (election_->IsFirst(place)) return End(status);
  if (!election_->GiveUp()) return;
  End(grpc::Status(grpc::StatusCode::UNAVAILABLE,
                   absl::StrCat("replica ", address, " records no more: ", status.error_message(),
                                "; a session that opens there would be missed")));
}

bool RecordStream::IsDecidedAgainst(int place) const {
  return election_ != nullptr && election_->IsDecidedAgainst(place);
}

void RecordStream::EndAtStop() {
  {
    const std::lock_guard lock(mutex_);
    if (has_begun_here_) return;
  }
  End(Stopping());
}

void RecordStream::OnEnd(const absl::Status& status) {
  if (IsHere()) End(ToGrpc(status));
}

void RecordStream::OnOpened(const RecordingStart& start) {
  if (!IsHere()) return;
  {
    const std::lock_guard lock(mutex_);
    has_begun_here_ = true;
  }
  FillAndPush([&](v1::RecordSessionResponse& message) {
    v1::RecordingHeader* header = message.mutable_header();
    header->set_program(program_);
    *header->mutable_open_time() = convert::ToProto(start.open_time);
    *header->mutable_open() = start.open;
    convert::ToProto(start.session, header->mutable_opened());
    header->set_map_sha256(start.map_sha256);
  });
}

void RecordStream::OnScan(const v1::Scan& scan, const ScanAnswer& answer) {
  if (!IsHere()) return;
  FillAndPush([&](v1::RecordSessionResponse& message) {
    *message.mutable_scan()->mutable_scan() = scan;
    convert::ToProto(answer, message.mutable_scan()->mutable_answer());
  });
}

void RecordStream::OnFix(const v1::PositionFix& fix, const FixAnswer& answer) {
  if (!IsHere()) return;
  if (!takes_fixes_) {
    return End(grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                            "the vehicle sends position fixes, which this client cannot record; "
                            "record it with a newer one"));
  }
  FillAndPush([&](v1::RecordSessionResponse& message) {
    *message.mutable_fix()->mutable_fix() = fix;
    convert::ToProto(answer, message.mutable_fix()->mutable_answer());
  });
}

/// Without memory the recording ends: one with a gap would be none.
template <typename Fill>
void RecordStream::FillAndPush(Fill fill) {
  v1::RecordSessionResponse message;
  absl::Status pushed = FillWithinMemory(&message, [&] { fill(message); });
  if (pushed.ok()) pushed = WithinMemory([&] { Push(std::move(message)); });
  if (!pushed.ok()) End(ToGrpc(pushed));
}

void RecordStream::Push(v1::RecordSessionResponse message) {
  const std::size_t size = message.ByteSizeLong();
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  if (waiting_bytes_ + size > kMaxWaiting_bytes) {
    EndLocked(grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED,
                           absl::StrCat("the recording is read too slowly: ", kMaxWaiting_bytes,
                                        " bytes wait, which is the limit")));
  } else {
    waiting_.push_back(std::move(message));
    waiting_bytes_ += size;
  }
  Pump();
}

void RecordStream::OnWrite(v1::RecordSessionResponse& message) {
  waiting_bytes_ -= message.ByteSizeLong();
}

}  // namespace dcloc::server
