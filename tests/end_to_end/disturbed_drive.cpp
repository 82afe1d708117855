#include "tests/end_to_end/disturbed_drive.h"

#include <algorithm>
#include <random>
#include <stop_token>
#include <thread>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMaxRecovery(5);

/// How far a vehicle is, and how far it may go until what is to befall it has done so.
struct Pace {
  std::atomic<int> answered_count = 0;
  std::atomic<int> may_send_count = std::numeric_limits<int>::max();

  void Allow(int count) {
    may_send_count = count;
    may_send_count.notify_all();
  }
  void AllowAll() { Allow(std::numeric_limits<int>::max()); }

  /// Until scan `index` may be sent.
  void WaitFor(int index) const {
    for (int count = may_send_count; count <= index; count = may_send_count) {
      may_send_count.wait(count);
    }
  }
};

absl::Status DriveAtPace(client::Session& session, const DriveScans& scans, Pace& pace) {
  const std::jthread sender([&] {
    for (int i = 0; i < scans.count; ++i) {
      pace.WaitFor(i);
      if (!session.Send(scans.at(i)).ok()) return;
    }
    session.CloseSending();
  });
  int count = 0;
  absl::Status status;
  while (auto answer = session.Next()) {
    if (count == scans.count || NumberOf(*answer) != scans.at(count).sequence_number()) {
      status =
          absl::InternalError(absl::StrFormat("answer %d is scan %d's", count, NumberOf(*answer)));
      break;
    }
    scans.take(*std::move(answer));
    pace.answered_count = ++count;
  }
  session.Cancel();  // so that the sender does not wait for ever
  pace.AllowAll();
  if (!status.ok()) return status;
  if (!session.EndStatus().ok()) return session.EndStatus();
  if (count == scans.count) return absl::OkStatus();
  return absl::InternalError(absl::StrFormat("%d of %d scans were answered", count, scans.count));
}

/// Cuts and restarts, and sees how long the vehicle needs to get over each.
class Saboteur {
 public:
  Saboteur(const client::Session& session, SessionSite& site, const Disturbances& disturbances,
           Pace& pace)
      : session_(session), site_(site), disturbances_(disturbances), pace_(pace) {}

  /// The vehicle stops a little after each moment until it has got over what befell it there.
  absl::Status Run(const std::stop_token& stop, int scan_count) {
    const int count = disturbances_.cut_count + disturbances_.restart_count;
    const int interval = scan_count / (count + 1);
    std::mt19937 random(disturbances_.seed);
    std::uniform_int_distribution<int> offset(-interval / 4, interval / 4);
    for (int i = 1; i <= count; ++i) {
      const int moment = i * interval + offset(random);
      pace_.Allow(moment + interval / 2);
      if (!WaitUntil(stop, [&] { return pace_.answered_count >= moment; })) {
        return absl::InternalError("the drive was over too soon");
      }
      absl::Status status =
          i * disturbances_.restart_count / count > restart_count_ ? Restart() : Cut();
      const Clock::time_point begin = Clock::now();
      if (status.ok() && WaitUntil(stop, [&] { return GotOver() >= i; })) {
        longest_ = std::max<std::chrono::duration<double>>(longest_, Clock::now() - begin);
        continue;
      }
      pace_.AllowAll();
      return status;
    }
    pace_.AllowAll();
    return absl::OkStatus();
  }

  std::chrono::duration<double> longest() const { return longest_; }

 private:
  template <typename Condition>
  static bool WaitUntil(const std::stop_token& stop, Condition condition) {
    while (!condition() && !stop.stop_requested()) std::this_thread::sleep_for(500us);
    return !stop.stop_requested();
  }

  std::int64_t GotOver() const {
    const client::SessionStats stats = session_.stats();
    return stats.resume_count + stats.restart_count;
  }

  absl::Status Cut() {
    site_.Cut();
    return absl::OkStatus();
  }

  absl::Status Restart() {
    const bool kills =
        disturbances_.restarts == Disturbances::Restarts::kInTurn && restart_count_ % 2 == 1;
    ++restart_count_;
    return site_.Restart(kills ? SessionSite::End::kKilled : SessionSite::End::kTerminated);
  }

  const client::Session& session_;
  SessionSite& site_;
  const Disturbances& disturbances_;
  Pace& pace_;
  int restart_count_ = 0;
  std::chrono::duration<double> longest_{};
};

}  // namespace

client::SessionOptions CampaignOptions() {
  client::SessionOptions options{.when_full = client::FullQueue::kBlock,
                                 .max_unread_answer_count = 16};
  options.reconnect =
      client::ReconnectOptions{.initial_backoff = 10ms, .max_backoff = 200ms, .give_up_after = 60s};
  return options;
}

std::int64_t NumberOf(const v1::LocalizeResponse& answer) {
  return answer.has_result() ? answer.result().sequence_number()
                             : answer.rejected().sequence_number();
}

absl::Status DriveUndisturbed(client::Session& session, const DriveScans& scans) {
  Pace pace;
  return DriveAtPace(session, scans, pace);
}

absl::Status DriveDisturbed(client::Session& session, const DriveScans& scans, SessionSite& site,
                            const Disturbances& disturbances, Recoveries& recoveries) {
  Pace pace;
  Saboteur saboteur(session, site, disturbances, pace);
  absl::Status disturbed;
  absl::Status driven;
  {
    const std::jthread thread(
        [&](const std::stop_token& stop) { disturbed = saboteur.Run(stop, scans.count); });
    driven = DriveAtPace(session, scans, pace);
  }
  if (!driven.ok()) return driven;
  if (!disturbed.ok()) return disturbed;
  recoveries = {.longest = saboteur.longest(), .stats = session.stats()};
  const client::SessionStats& stats = recoveries.stats;
  if (recoveries.longest > kMaxRecovery) {
    return absl::InternalError(
        absl::StrFormat("once it took %.1f s until it went on", recoveries.longest.count()));
  }
  if (stats.resume_count == disturbances.cut_count &&
      stats.restart_count == disturbances.restart_count) {
    return absl::OkStatus();
  }
  return absl::InternalError(absl::StrFormat("sessions were resumed %d times, begun anew %d times",
                                             stats.resume_count, stats.restart_count));
}

}  // namespace dcloc
