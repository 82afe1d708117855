#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>

#include "client/load/load_options.h"
#include "client/load/recorder.h"
#include "client/load/route.h"
#include "client/load/scheduler.h"
#include "client/load/vehicle_link.h"
#include "client/load/vehicle_state.h"
#include "client/sdk/connection.h"
#include "client/sdk/prior.h"

namespace dcloc::load {

/// What all vehicles of a run share; outlives them.
struct Fleet {
  const LoadOptions& options;
  Scheduler& scheduler;
  Recorder& recorder;
};

/// One simulated vehicle: drives its route again and again, each time as a session of its own, and
/// checks every answer. Has no thread: it acts on the scheduler's and on gRPC's.
class Vehicle final : public client::Connection::Host {
 public:
  using Clock = Scheduler::Clock;

  /// `fleet` and `route` outlive it.
  Vehicle(int index, const Fleet& fleet, const Route& route, VehicleLink link);
  /// Only once it is done, and the scheduler has gone.
  ~Vehicle() override;

  /// Opens the first session.
  void Start();
  /// Stops sending; ends once all sent scans are answered.
  void Finish();
  /// Ends at once; unanswered scans are lost.
  void Cancel();
  /// Has ended and will begin nothing more.
  bool done() const;

 private:
  struct Outgoing {
    Expected expected;
    Clock::time_point due;
  };

  /// One drive along the route: one session, over as many streams as it takes.
  struct Trip {
    std::int64_t number = 0;
    std::size_t first = 0;
    std::size_t next = 0;                    ///< the scan that is due next
    std::optional<Clock::time_point> begin;  ///< none before it is open for the first time
    Clock::time_point last_due;
    Clock::time_point stalled_until;
    std::optional<Outgoing> held;  ///< to be sent behind the next one
    std::string resume_token;      ///< empty: the next stream opens a session anew
    client::Prior prior;
    bool is_resumable = false;  ///< the server keeps the session when its stream breaks
    bool asks_for_version = false;
  };

  client::Connection::Fill FillRequest(v1::LocalizeRequest* request) override;
  bool HasRoom() const override;
  void Take(v1::LocalizeResponse response) override;
  void OnEnd(const grpc::Status& status) override;

  // All with the mutex held.
  void BeginTrip(std::size_t first);
  void OpenStream();
  v1::OpenSession OpenMessage() const;
  void TakeOpened(const v1::SessionOpened& opened);
  void TakeAnswer(const v1::LocalizeResponse& answer);
  std::int64_t ExpectedVersion(const v1::LocalizeResponse& answer);
  void Count(const v1::LocalizeResponse& answer, const Outgoing& answered);
  void PlanNextScan();
  void SendDue();
  void SendNext(Clock::time_point due);
  void Push(const Outgoing& outgoing);
  void Flush();
  void ReadOn();
  void AfterEnd();
  bool MayGoOn() const;
  bool HasStream() const;
  bool IsEnding() const;
  void Restart();
  void EndOrBeginTrip(std::size_t first);
  void LoseOutbox();
  void PlanDisconnect();
  void Cut();
  void PlanStall();
  void Stall();
  bool Chance(double share);
  Clock::duration TimeToNext(double events_per_min);

  /// Runs `action` at `time` with the mutex held, unless another trip has begun by then.
  void At(Clock::time_point time, void (Vehicle::*action)());

  const int index_;
  const Fleet fleet_;
  const Route& route_;
  const VehicleLink link_;
  const std::unique_ptr<v1::LocalizationService::Stub> stub_;

  mutable std::mutex mutex_;
  std::mt19937_64 random_;
  const bool is_slow_reader_;  ///< drawn once: reads only every `slow_read_interval`
  VehicleState state_ = VehicleState::kDriving;

  Trip trip_;
  std::int64_t map_version_ = 0;                  ///< of the newest answer
  std::optional<Clock::time_point> last_answer_;  ///< none since a trip began as planned
  std::deque<Outgoing> outbox_;                   ///< not answered yet, in the order of sending
  std::size_t sent_count_ = 0;                    ///< of them, on this stream

  // Of the stream.
  std::unique_ptr<client::Connection> connection_;  ///< none between two streams
  StreamState stream_ = StreamState::kOpening;
  std::size_t window_ = 0;  ///< scans that may be on their way, once it is open
  std::optional<grpc::Status> end_status_;
  Clock::time_point open_time_;
  Clock::time_point read_again_;  ///< of a slow reader
};

}  // namespace dcloc::load
