#include "server/admin/record_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "google/protobuf/util/time_util.h"
#include "server/base/status.h"

namespace dcloc::server {

std::shared_ptr<void> RecordingSlots::Take(int max) {
  if (taken_->fetch_add(1) >= max) {
    taken_->fetch_sub(1);
    return nullptr;
  }
  return {taken_.get(), [taken = taken_](void*) { taken->fetch_sub(1); }};
}

std::shared_ptr<RecordStream> RecordStream::Start(OpenCalls& open_calls, std::string program) {
  std::shared_ptr<RecordStream> stream(new RecordStream(open_calls, std::move(program)));
  stream->self_ = stream;
  return stream;
}

void RecordStream::Begin(const absl::Status& status, std::shared_ptr<void> slot) {
  if (!status.ok()) End(ToGrpc(status));
  const std::lock_guard lock(mutex_);
  begun_ = true;
  slot_ = std::move(slot);
  // The caller knows from then on that the vehicle's next session is recorded.
  if (status.ok() && !end_status_) StartSendInitialMetadata();
  Pump();
}

void RecordStream::OnOpened(const RecordingStart& start) {
  v1::RecordSessionResponse message;
  v1::RecordingHeader* header = message.mutable_header();
  header->set_program(program_);
  *header->mutable_open_time() = google::protobuf::util::TimeUtil::NanosecondsToTimestamp(
      start.open_time.time_since_epoch().count());
  *header->mutable_open() = start.open;
  convert::ToProto(start.session, header->mutable_opened());
  header->set_map_sha256(start.map_sha256);
  Push(std::move(message));
}

void RecordStream::OnScan(const v1::Scan& scan, const ScanAnswer& answer) {
  v1::RecordSessionResponse message;
  *message.mutable_scan()->mutable_scan() = scan;
  convert::ToProto(answer, message.mutable_scan()->mutable_answer());
  Push(std::move(message));
}

void RecordStream::Push(v1::RecordSessionResponse message) {
  const std::size_t size = message.ByteSizeLong();
  {
    const std::lock_guard lock(mutex_);
    if (end_status_) return;
    if (waiting_bytes_ + size <= kMaxWaiting_bytes) {
      waiting_bytes_ += size;
      waiting_.push_back(std::move(message));
      return Pump();
    }
  }
  End(grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED,
                   absl::StrCat("the recording is read too slowly: ", kMaxWaiting_bytes,
                                " bytes wait, which is the limit")));
}

void RecordStream::End(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (!end_status_) end_status_ = status;
  if (!status.ok()) waiting_.clear();
  Pump();
}

void RecordStream::OnWriteDone(bool ok) {
  const std::lock_guard lock(mutex_);
  writing_ = false;
  if (!ok) {
    if (!end_status_) end_status_ = grpc::Status::CANCELLED;
    waiting_.clear();
  }
  Pump();
}

void RecordStream::OnDone() { const std::shared_ptr<RecordStream> last = std::move(self_); }

void RecordStream::Pump() {
  if (!begun_ || writing_ || finished_) return;
  if (!waiting_.empty()) {
    message_ = std::move(waiting_.front());
    waiting_.pop_front();
    waiting_bytes_ -= message_.ByteSizeLong();
    writing_ = true;
    StartWrite(&message_);
  } else if (end_status_) {
    finished_ = true;
    slot_.reset();
    Finish(*end_status_);
  }
}

}  // namespace dcloc::server
