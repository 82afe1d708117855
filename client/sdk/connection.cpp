#include "client/sdk/connection.h"

#include <algorithm>
#include <string>
#include <utility>

namespace dcloc::client {

namespace {

/// The server refuses other names anyway; gRPC would abort over some of them.
bool IsHeaderValue(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c > ' ' && c <= '~'; });
}

}  // namespace

Connection::Connection(v1::LocalizationService::Stub& stub, std::mutex& mutex, Host& host,
                       const v1::OpenSession& open)
    : mutex_(mutex), host_(host) {
  // A proxy that sends a vehicle's streams to one server lets its sessions be resumed.
  if (IsHeaderValue(open.vehicle_id())) {
    context_.AddMetadata("x-session-id", open.vehicle_id());
  }
  *request_.mutable_open() = open;
  stub.async()->Localize(&context_, this);
  AddHold();
  StartWrite(&request_);
  StartRead(&response_);
  StartCall();
}

void Connection::WriteOn() {
  if (write_ != Side::kIdle || read_ == Side::kEnded) return;
  switch (host_.FillRequest(&request_)) {
    case Fill::kRequest:
      write_ = Side::kUnderWay;
      StartWrite(&request_);
      break;
    case Fill::kNothingMore:
      write_ = Side::kEnded;
      StartWritesDone();
      break;
    case Fill::kNothingYet:
      break;
  }
}

void Connection::ReadOn() {
  if (read_ != Side::kIdle || !host_.HasRoom()) return;
  read_ = Side::kUnderWay;
  StartRead(&response_);
}

void Connection::Cancel() {
  context_.TryCancel();
  ReadOn();
}

void Connection::OnWriteDone(bool ok) {
  const std::lock_guard lock(mutex_);
  write_ = ok ? Side::kIdle : Side::kEnded;
  WriteOn();
}

void Connection::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    read_ = ok ? Side::kIdle : Side::kEnded;
    if (ok) {
      host_.Take(std::move(response_));
      ReadOn();
      WriteOn();
      return;
    }
    // The end; the status follows with OnDone.
  }
  RemoveHold();
}

void Connection::OnDone(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  host_.OnEnd(status);
}

}  // namespace dcloc::client
