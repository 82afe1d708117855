#include "server/admin/record_elsewhere.h"

#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/admin/record_election.h"
#include "server/admin/relay.h"

namespace dcloc::server {
namespace {

using AsyncAdmin = v1::AdminService::StubInterface::async_interface;
using RecordRelay = Relay<v1::RecordSessionRequest, v1::RecordSessionResponse>;
using Done = std::function<void(const absl::Status& status)>;

/// Waits until all replicas have begun, or one has not, and until all were asked: with `done` the
/// call may end, from which theirs are made.
class Beginning {
 public:
  Beginning(std::size_t count, Done done) : left_(count), done_(std::move(done)) {}

  void OnAllAsked() {
    Done done;
    absl::Status status;
    {
      const std::lock_guard lock(mutex_);
      is_asking_ = false;
      if (fault_.ok() && left_ > 0) return;
      done = std::exchange(done_, nullptr);
      status = fault_;
    }
    if (done != nullptr) done(status);
  }

  void OnBegun() { Tell(absl::OkStatus()); }
  void OnFault(const std::string& address, absl::string_view why) {
    Tell(absl::UnavailableError(absl::StrCat("replica ", address, " does not record: ", why,
                                             "; a session that opens there would be missed")));
  }

 private:
  void Tell(const absl::Status& status) {
    Done done;
    {
      const std::lock_guard lock(mutex_);
      if (fault_.ok()) fault_ = status;
      if (status.ok() && --left_ > 0) return;
      if (is_asking_) return;
      done = std::exchange(done_, nullptr);
    }
    if (done != nullptr) done(status);
  }

  std::mutex mutex_;
  std::size_t left_;
  bool is_asking_ = true;
  absl::Status fault_;
  Done done_;  ///< null once it was called
};

RecordRelay::Listener ListenerOf(int place, std::string address, RecordingRequests& recordings,
                                 const std::shared_ptr<RecordStream>& stream,
                                 const std::shared_ptr<Beginning>& beginning) {
  return {.on_begin = [beginning] { beginning->OnBegun(); },
          .on_message =
              [place, &recordings, stream](v1::RecordSessionResponse message) {
                if (message.has_header()) recordings.Forget(*stream);
                stream->OnRelayed(place, std::move(message));
              },
          .on_end =
              [place, address = std::move(address), stream, beginning](const grpc::Status& status) {
                // Once a session has opened elsewhere, nobody waits for this one.
                if (stream->IsDecidedAgainst(place)) {
                  beginning->OnBegun();
                } else {
                  beginning->OnFault(address, status.error_message());
                }
                stream->OnRelayEnd(place, address, status);
              }};
}

}  // namespace

void RecordElsewhere(Replicas& replicas, RecordingRequests& recordings,
                     const std::vector<std::string>& others,
                     const grpc::CallbackServerContext& context,
                     const v1::RecordSessionRequest& request,
                     const std::shared_ptr<RecordStream>& stream, Done done) {
  const auto election = std::make_shared<RecordElection>();
  stream->Join(election);
  const auto beginning = std::make_shared<Beginning>(
      others.size(), [election, done = std::move(done)](const absl::Status& status) {
        if (!status.ok()) election->GiveUp();
        done(status);
      });
  std::vector<Replicas::Line> lines;
  for (const std::string& address : others) {
    absl::StatusOr<Replicas::Line> line = replicas.Call(address, context);
    if (!line.ok()) {
      beginning->OnFault(address, line.status().message());
      return beginning->OnAllAsked();
    }
    election->Add(static_cast<int>(lines.size()), line->context);
    lines.push_back(*std::move(line));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int place = static_cast<int>(i);
    RecordRelay::Start(std::move(lines[i]), request, &AsyncAdmin::RecordSession,
                       replicas.bounds().answer,
                       ListenerOf(place, others[i], recordings, stream, beginning));
  }
  beginning->OnAllAsked();
}

}  // namespace dcloc::server
