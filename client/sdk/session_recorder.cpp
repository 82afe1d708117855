#include "client/sdk/session_recorder.h"

#include <ctime>
#include <utility>

namespace dcloc::client {

absl::Status SessionRecorder::Begin(const std::string& file, const v1::OpenSession& open,
                                    const v1::SessionOpened& opened) {
  v1::RecordingHeader header;
  header.set_program("dcloc SDK");
  header.mutable_open_time()->set_seconds(std::time(nullptr));
  *header.mutable_open() = open;
  *header.mutable_opened() = opened;
  auto writer = RecordingWriter::Create(file, std::move(header));
  if (!writer.ok()) return writer.status();
  writer_.emplace(*std::move(writer));
  return absl::OkStatus();
}

void SessionRecorder::Add(const v1::LocalizeRequest& request, const v1::LocalizeResponse& answer) {
  if (!writer_) return;
  if (answer.has_position_fix_answer()) {
    v1::RecordedFix recorded;
    *recorded.mutable_fix() = request.position_fix();
    *recorded.mutable_answer() = answer.position_fix_answer();
    return writer_->Add(recorded);
  }
  v1::RecordedScan recorded;
  *recorded.mutable_scan() = request.scan();
  *recorded.mutable_answer() = answer;
  recorded.mutable_answer()->set_from_memory(false);  // it is here for the first time
  writer_->Add(recorded);
}

void SessionRecorder::End(const std::string& reason) {
  if (!writer_) return;
  status_ = writer_->Close(reason.empty() ? "the session has ended" : reason);
  writer_.reset();
}

}  // namespace dcloc::client
