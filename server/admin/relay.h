#pragma once

#include <grpcpp/alarm.h>
#include <grpcpp/support/client_callback.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "server/base/within_memory.h"
#include "server/replicas/replicas.h"

namespace dcloc::server {

/// Another server's stream, read for a caller of this one. Deletes itself at its end. It is
/// cancelled when the caller's call is, which its context was made from.
template <typename Request, typename Message>
class Relay final : public grpc::ClientReadReactor<Message> {
 public:
  using Method = void (v1::AdminService::StubInterface::async_interface::*)(
      grpc::ClientContext*, const Request*, grpc::ClientReadReactor<Message>*);

  /// Called one after the other.
  struct Listener {
    std::function<void()> on_begin;  ///< the headers have come; not called where none come
    std::function<void(Message message)> on_message;
    std::function<void(const grpc::Status& status)> on_end;
  };

  /// The other server has `begin_bound` to begin; then the stream ends with DEADLINE_EXCEEDED.
  static void Start(Replicas::Line line, const Request& request, Method method,
                    std::chrono::milliseconds begin_bound, Listener listener) {
    auto* relay = new Relay(std::move(line), request, std::move(listener));
    (relay->line_.stub->async()->*method)(relay->line_.context.get(), &relay->request_, relay);
    relay->LimitBegin(begin_bound);
    relay->StartRead(&relay->message_);
    relay->StartCall();
  }

  void OnReadInitialMetadataDone(bool ok) override {
    if (ok && Take(*begin_, Begin::kBegun)) {
      alarm_.Cancel();
      listener_.on_begin();
    }
  }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    const absl::Status passed = WithinMemory([this] { listener_.on_message(std::move(message_)); });
    if (!passed.ok()) return line_.context->TryCancel();
    message_.Clear();
    this->StartRead(&message_);
  }

  void OnDone(const grpc::Status& status) override {
    const bool is_overdue = *begin_ == Begin::kOverdue;
    listener_.on_end(
        is_overdue ? grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED, "it has not begun in time")
                   : status);
    delete this;
  }

 private:
  enum class Begin { kAwaited, kBegun, kOverdue };

  static bool Take(std::atomic<Begin>& begin, Begin end) {
    Begin awaited = Begin::kAwaited;
    return begin.compare_exchange_strong(awaited, end);
  }

  /// The alarm may ring while this goes, so it has its own hold on what it uses.
  void LimitBegin(std::chrono::milliseconds bound) {
    alarm_.Set(std::chrono::system_clock::now() + bound,
               [begin = begin_, context = line_.context](bool has_rung) {
                 if (has_rung && Take(*begin, Begin::kOverdue)) context->TryCancel();
               });
  }

  Relay(Replicas::Line line, const Request& request, Listener listener)
      : line_(std::move(line)), request_(request), listener_(std::move(listener)) {}

  const Replicas::Line line_;
  const Request request_;
  const Listener listener_;
  const std::shared_ptr<std::atomic<Begin>> begin_ =
      std::make_shared<std::atomic<Begin>>(Begin::kAwaited);
  grpc::Alarm alarm_;
  Message message_;  ///< the transport's while a read is under way
};

}  // namespace dcloc::server
