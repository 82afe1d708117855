#pragma once

#include <grpcpp/support/client_callback.h>

#include <functional>
#include <memory>
#include <utility>

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

  static void Start(Replicas::Line line, const Request& request, Method method, Listener listener) {
    auto* relay = new Relay(std::move(line), request, std::move(listener));
    (relay->line_.stub->async()->*method)(relay->line_.context.get(), &relay->request_, relay);
    relay->StartRead(&relay->message_);
    relay->StartCall();
  }

  void OnReadInitialMetadataDone(bool ok) override {
    if (ok) listener_.on_begin();
  }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    listener_.on_message(std::move(message_));
    message_.Clear();
    this->StartRead(&message_);
  }

  void OnDone(const grpc::Status& status) override {
    listener_.on_end(status);
    delete this;
  }

 private:
  Relay(Replicas::Line line, const Request& request, Listener listener)
      : line_(std::move(line)), request_(request), listener_(std::move(listener)) {}

  const Replicas::Line line_;
  const Request request_;
  const Listener listener_;
  Message message_;  ///< the transport's while a read is under way
};

}  // namespace dcloc::server
