#include "client/sdk/session.h"

#include <grpcpp/client_context.h>
#include <grpcpp/support/client_callback.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/sdk/status.h"
#include "dcloc/v1/localization_service.grpc.pb.h"

namespace dcloc::client {

// The stream under a session. What gRPC asks for is kept here: at most one write and one read are
// under way; while threads outside of the reactions may start operations there is a hold, given
// back once, when the read side has ended; nothing is touched after OnDone.
class Session::Stream final
    : public grpc::ClientBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse> {
 public:
  Stream(const std::shared_ptr<grpc::Channel>& channel, v1::OpenSession open,
         const SessionOptions& options)
      : options_(options), stub_(v1::LocalizationService::NewStub(channel)) {
    *request_.mutable_open() = std::move(open);
    stub_->async()->Localize(&context_, this);
    AddHold();
    writing_ = true;
    StartWrite(&request_);
    reading_ = true;
    StartRead(&response_);
    StartCall();
  }

  ~Stream() override {
    std::unique_lock lock(mutex_);
    context_.TryCancel();
    abandoned_ = true;
    ReadOn();
    changed_.wait(lock, [&] { return end_status_.has_value(); });
  }

  absl::Status WaitUntilOpen() {
    std::unique_lock lock(mutex_);
    const bool in_time = changed_.wait_for(lock, options_.open_timeout, [&] {
      return opened_.has_value() || end_status_.has_value();
    });
    if (opened_) return absl::OkStatus();
    if (!in_time) {
      return absl::DeadlineExceededError(absl::StrCat(
          "the server has not opened the session within ", options_.open_timeout.count(), " ms"));
    }
    return end_status_->ok() ? absl::InternalError("the server ended the stream without opening it")
                             : *end_status_;
  }

  // Set once before the session is given out, so it needs no lock.
  const v1::SessionOpened& opened() const { return *opened_; }

  absl::Status Send(v1::Scan scan) {
    std::unique_lock lock(mutex_);
    if (options_.when_full == FullQueue::kBlock) {
      changed_.wait(lock, [&] {
        return queue_.size() < options_.max_queued_scan_count || !writable_ || sending_closed_;
      });
    }
    if (sending_closed_) return absl::FailedPreconditionError("sending has been closed");
    if (!writable_) return absl::UnavailableError("the session has ended");
    if (queue_.size() >= options_.max_queued_scan_count) {
      return absl::ResourceExhaustedError(
          absl::StrCat("the queue holds ", queue_.size(), " scans, its limit"));
    }
    queue_.push_back(std::move(scan));
    WriteOn();
    return absl::OkStatus();
  }

  void CloseSending() {
    const std::lock_guard lock(mutex_);
    if (sending_closed_) return;
    sending_closed_ = true;
    changed_.notify_all();
    WriteOn();
  }

  std::optional<v1::LocalizeResponse> Next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !answers_.empty() || end_status_.has_value(); });
    if (answers_.empty()) return std::nullopt;
    v1::LocalizeResponse answer = std::move(answers_.front());
    answers_.pop_front();
    ReadOn();
    return answer;
  }

  void Cancel() {
    const std::lock_guard lock(mutex_);
    context_.TryCancel();
    ReadOn();
  }

  absl::Status EndStatus() const {
    const std::lock_guard lock(mutex_);
    return end_status_.value_or(absl::FailedPreconditionError("the session has not ended"));
  }

 private:
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) writable_ = false;
    WriteOn();
    changed_.notify_all();
  }

  void OnReadDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      reading_ = false;
      if (ok) {
        Take();
        ReadOn();
        changed_.notify_all();
        return;
      }
      // The end; the status follows with OnDone.
      read_ended_ = true;
      writable_ = false;
      changed_.notify_all();
    }
    RemoveHold();
  }

  void OnDone(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    end_status_ = FromGrpc(status);
    const std::size_t unanswered = sent_count_ + queue_.size() - answer_count_;
    if (end_status_->ok() && unanswered > 0) {
      end_status_ = absl::UnavailableError(
          absl::StrCat("the server ended the session with ", unanswered, " scans unanswered"));
    }
    changed_.notify_all();
  }

  // Starts the next write if there is one and none is under way.
  void WriteOn() {
    if (writing_ || !writable_ || read_ended_) return;
    if (!queue_.empty()) {
      *request_.mutable_scan() = std::move(queue_.front());
      queue_.pop_front();
      ++sent_count_;
      writing_ = true;
      StartWrite(&request_);
    } else if (sending_closed_) {
      writable_ = false;
      StartWritesDone();
    }
  }

  // Starts the next read if there is room for what it brings and none is under way.
  void ReadOn() {
    if (reading_ || read_ended_) return;
    if (answers_.size() >= options_.max_unread_answer_count && !abandoned_) return;
    reading_ = true;
    StartRead(&response_);
  }

  void Take() {
    if (abandoned_) return;
    if (!opened_) {
      if (response_.has_opened()) {
        opened_ = std::move(*response_.mutable_opened());
      } else {
        context_.TryCancel();
      }
      return;
    }
    ++answer_count_;
    answers_.push_back(std::move(response_));
  }

  const SessionOptions options_;
  const std::unique_ptr<v1::LocalizationService::Stub> stub_;
  grpc::ClientContext context_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  v1::LocalizeRequest request_;    ///< the transport's while writing_
  v1::LocalizeResponse response_;  ///< the transport's while reading_
  std::deque<v1::Scan> queue_;
  std::deque<v1::LocalizeResponse> answers_;
  std::optional<v1::SessionOpened> opened_;
  std::optional<absl::Status> end_status_;
  std::size_t sent_count_ = 0;
  std::size_t answer_count_ = 0;
  bool writing_ = false;
  bool reading_ = false;
  bool writable_ = true;  ///< more may be written, as far as the transport is concerned
  bool read_ended_ = false;
  bool sending_closed_ = false;
  bool abandoned_ = false;
};

absl::Status Validate(const SessionOptions& options) {
  const auto below_one = [](const char* field) {
    return absl::InvalidArgumentError(absl::StrCat(field, " is 0; it must be at least 1"));
  };
  if (options.max_queued_scan_count == 0) return below_one("max_queued_scan_count");
  if (options.max_unread_answer_count == 0) return below_one("max_unread_answer_count");
  if (options.open_timeout.count() <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("open_timeout is ", options.open_timeout.count(), " ms; it must be positive"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Session>> Session::Open(
    const std::shared_ptr<grpc::Channel>& channel, v1::OpenSession open,
    const SessionOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  auto stream = std::make_unique<Stream>(channel, std::move(open), options);
  if (absl::Status status = stream->WaitUntilOpen(); !status.ok()) return status;
  return std::unique_ptr<Session>(new Session(std::move(stream)));
}

Session::Session(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
Session::~Session() = default;

const v1::SessionOpened& Session::opened() const { return stream_->opened(); }
absl::Status Session::Send(v1::Scan scan) { return stream_->Send(std::move(scan)); }
void Session::CloseSending() { stream_->CloseSending(); }
std::optional<v1::LocalizeResponse> Session::Next() { return stream_->Next(); }
void Session::Cancel() { stream_->Cancel(); }
absl::Status Session::EndStatus() const { return stream_->EndStatus(); }

}  // namespace dcloc::client
