#include "server/app/server.h"

#include <algorithm>
#include <utility>

#include "server/app/access_notice.h"
#include "server/app/part_options.h"
#include "server/app/server_parts.h"
#include "server/base/status.h"
#include "server/config/credentials.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::milliseconds kLastBytesGrace(200);

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerConfig& config,
                                                      RegistrationMethods methods) {
  if (absl::Status status = Validate(config); !status.ok()) return status;
  auto gate = std::make_shared<CallGate>(config.max_call_rate_hz_per_connection);
  absl::StatusOr<Credentials> credentials = MakeCredentials(config, gate);
  if (!credentials.ok()) return credentials.status();
  absl::StatusOr<std::unique_ptr<SessionTickets>> tickets = TicketsOf(config);
  if (!tickets.ok()) return tickets.status();
  absl::StatusOr<Storage> storage = OpenStorage(config, MapStoreOptionsOf(config));
  if (!storage.ok()) return WithPrefix("data: ", storage.status());
  auto parts =
      std::make_unique<Parts>(config, std::move(methods), *std::move(storage), std::move(gate),
                              credentials->certificates, *std::move(tickets));
  if (absl::Status status = WarnOfOpenAccess(parts->access, config); !status.ok()) return status;
  parts->gate->SetProofNeeded(parts->access.needs_proof());
  if (absl::Status status = parts->Serve(credentials->credentials); !status.ok()) return status;
  return std::unique_ptr<Server>(new Server(std::move(parts)));
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

const std::string& Server::address() const { return parts_->address; }

std::string Server::metrics_address() const {
  return parts_->metrics_pages == nullptr ? "" : parts_->metrics_pages->address();
}

absl::Status Server::Reload(const ServerConfig& config) {
  if (absl::Status status = Validate(config); !status.ok()) return status;
  if (config.log_level != parts_->config.log_level) {
    spdlog::set_level(spdlog::level::from_str(config.log_level));
  }
  for (const ConfigField* field : ChangedFields(parts_->config, config)) {
    if (field->reloadable) {
      TakeField(*field, config, &parts_->config);
      spdlog::info("setting taken key={}", field->key);
    } else {
      spdlog::warn("setting not taken, it needs a restart key={}", field->key);
    }
  }
  parts_->limits.Set(parts_->config);
  return absl::OkStatus();
}

void Server::Shutdown(std::chrono::milliseconds deadline) {
  const auto begin = std::chrono::steady_clock::now();
  const auto end = begin + deadline;
  parts_->liveness_ticker.reset();
  // What sessions of this server do not end.
  parts_->admin.EndWaiting();
  // A quarter of the time at most is the router's, and half of it the clients', to go by
  // themselves.
  const std::chrono::milliseconds notice = std::min(parts_->drain_notice, deadline / 4);
  const std::chrono::milliseconds grace = std::min(parts_->drain_grace, deadline / 2);
  parts_->BeginDrain(std::chrono::steady_clock::time_point::max(), grace);
  parts_->open_calls.WaitUntilNone(begin + notice);
  if (parts_->localization.Drain(grace) > 0) {
    parts_->open_calls.WaitUntilNone(std::chrono::steady_clock::now() + grace);
  }
  parts_->health_service.Shutdown();
  parts_->localization.EndAll(
      grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server is shutting down"));
  parts_->registry.RemoveDetached("the server is shutting down");
  parts_->open_calls.WaitUntilNone(end);
  parts_->listener->Stop();
  // What is left are calls beyond the deadline, last bytes on their way, and idle connections.
  parts_->server->Shutdown(std::chrono::system_clock::now() + kLastBytesGrace);
  // Cut-off calls end at once, but their last events may still be under way.
  parts_->open_calls.WaitUntilNone();
}

}  // namespace dcloc::server
