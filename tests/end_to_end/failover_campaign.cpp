#include <Eigen/Core>
#include <Eigen/LU>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "client/sdk/session.h"
#include "tests/end_to_end/failover_site.h"
#include "tests/end_to_end/run_program.h"
#include "tests/server/fixtures/town_drive.h"

// A vehicle drives in real time while the server that has its session is killed again and again.
// Another server goes on from the session's ticket: each scan is answered once and in order, soon,
// by a vehicle that tracks and does not jump.
namespace dcloc {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string server;
  int kill_count = 3;
  double rate = 1.0;
  unsigned seed = 1;
};

constexpr double kScansPerSecond = 13.4;
constexpr double kMetresPerScan = 0.84;     // 40 km/h
constexpr int kScansBetweenKills = 80;      // six seconds
constexpr int kScansBeforeFirst = 110;      // until it tracks, and has tickets
constexpr auto kMaxGap = 2s;                // from a kill to the next answer
constexpr int kMaxScansUntilTracking = 13;  // a second
constexpr double kMaxSigmas = 3.0;

/// What came of one kill.
struct Outcome {
  double gap_s = 0.0;            ///< from the kill to the next answer
  int scans_until_tracking = 0;  ///< answers before the first TRACKING one
  double jump_m = 0.0;
  double jump_sigmas = 0.0;
};

struct Told {
  v1::LocalizationResult result;
  Clock::time_point time;
};

Eigen::Vector2d ErrorOf(const v1::LocalizationResult& result, const Pose3& T_map_vehicle) {
  const v1::Vector3& p = result.pose().pose().translation_m();
  return Eigen::Vector2d(p.x(), p.y()) - T_map_vehicle.translation_m.head<2>();
}

Eigen::Matrix2d CovarianceOf(const v1::LocalizationResult& result) {
  const auto& values = result.pose().covariance();
  Eigen::Matrix2d covariance;
  covariance << values[0], values[1], values[6], values[7];
  return covariance;
}

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments)
      : arguments_(arguments),
        site_(arguments.server),
        scan_count_(kScansBeforeFirst + (arguments.kill_count + 1) * kScansBetweenKills) {}

  absl::Status Run() {
    const server::TownDrive town(50.0 + kMetresPerScan * scan_count_);
    scans_ = town.Scans();
    if (static_cast<int>(scans_.size()) < scan_count_) {
      return absl::InternalError("the drive is too short");
    }
    scans_.resize(static_cast<std::size_t>(scan_count_));
    truth_ = town.live.scans;
    if (absl::Status status = site_.Start(town.map); !status.ok()) return status;
    client::SessionOptions options{.when_full = client::FullQueue::kBlock};
    options.on_event = [this](const client::SessionEvent& event) {
      const std::lock_guard lock(mutex_);
      if (event.kind == client::SessionEvent::Kind::kDisconnected) {
        stream_ends_.push_back(Clock::now());
      }
    };
    auto session = client::Session::Open(site_.Channel(), town.Open(), options);
    if (!session.ok()) return session.status();
    if (absl::Status status = Drive(**session); !status.ok()) return status;
    stats_ = (*session)->stats();
    if (stats_.ticket_resume_count != arguments_.kill_count || stats_.restart_count != 0) {
      return absl::InternalError(absl::StrFormat("%d sessions went on by tickets, %d began anew",
                                                 stats_.ticket_resume_count, stats_.restart_count));
    }
    return Judge();
  }

  void Report() const {
    std::vector<double> gaps_s;
    int until_tracking = 0;
    double jump_m = 0.0;
    double jump_sigmas = 0.0;
    for (const Outcome& outcome : outcomes_) {
      gaps_s.push_back(outcome.gap_s);
      until_tracking = std::max(until_tracking, outcome.scans_until_tracking);
      jump_m = std::max(jump_m, outcome.jump_m);
      jump_sigmas = std::max(jump_sigmas, outcome.jump_sigmas);
    }
    std::ranges::sort(gaps_s);
    absl::PrintF(
        "%d scans, %d kills: each scan was answered once and in order. From a kill to the next "
        "answer %.3f s in the median and %.3f s at most; at most %d scans until TRACKING, %.3f m "
        "and %.2f sigma of jump\n",
        scans_.size(), outcomes_.size(), gaps_s.empty() ? 0.0 : gaps_s[gaps_s.size() / 2],
        gaps_s.empty() ? 0.0 : gaps_s.back(), until_tracking, jump_m, jump_sigmas);
  }

 private:
  absl::Status Drive(client::Session& session) {
    const std::jthread sender([&](const std::stop_token& stop) {
      const auto interval = std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(1.0 / (kScansPerSecond * arguments_.rate)));
      Clock::time_point due = Clock::now();
      for (const v1::Scan& scan : scans_) {
        std::this_thread::sleep_until(due += interval);
        if (stop.stop_requested() || !session.Send(scan).ok()) return;
      }
      session.CloseSending();
    });
    absl::Status sabotaged;
    const std::jthread saboteur(
        [&](const std::stop_token& stop) { sabotaged = KillAgainAndAgain(stop); });
    absl::Status status;
    while (auto answer = session.Next()) {
      const std::int64_t expected = scans_[told_count_].sequence_number();
      if (!answer->has_result() || answer->result().sequence_number() != expected) {
        status = absl::InternalError(absl::StrFormat("scan %d was not answered in its turn: %s",
                                                     expected, answer->ShortDebugString()));
        break;
      }
      const std::lock_guard lock(mutex_);
      told_.push_back({std::move(*answer->mutable_result()), Clock::now()});
      ++told_count_;
      if (told_count_ == scans_.size()) break;
    }
    session.Cancel();
    if (!status.ok()) return status;
    if (!sabotaged.ok()) return sabotaged;
    if (told_count_ == scans_.size()) return absl::OkStatus();
    return absl::InternalError(absl::StrFormat("%d of %d scans were answered: %s", told_count_,
                                               scans_.size(), session.EndStatus().ToString()));
  }

  absl::Status KillAgainAndAgain(const std::stop_token& stop) {
    std::mt19937 random(arguments_.seed);
    std::uniform_int_distribution<int> offset(0, kScansBetweenKills / 3);
    for (int i = 0; i < arguments_.kill_count; ++i) {
      const int moment = kScansBeforeFirst + i * kScansBetweenKills + offset(random);
      while (static_cast<int>(told_count_) < moment) {
        if (stop.stop_requested()) return absl::OkStatus();
        std::this_thread::sleep_for(500us);
      }
      {
        const std::lock_guard lock(mutex_);
        kills_.push_back(Clock::now());
      }
      site_.KillOwner();
      if (absl::Status status = site_.Revive(); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  /// The first answer of the server that goes on: it comes after the other's stream has ended.
  std::size_t FirstAfter(Clock::time_point stream_end) const {
    const auto first = std::ranges::find_if(
        told_, [stream_end](const Told& told) { return told.time > stream_end; });
    return static_cast<std::size_t>(first - told_.begin());
  }

  /// Against the truth, so that the vehicle's own motion is no jump.
  absl::Status Judge() {
    if (stream_ends_.size() != kills_.size()) {
      return absl::InternalError(
          absl::StrFormat("%d streams ended by %d kills", stream_ends_.size(), kills_.size()));
    }
    for (std::size_t i = 0; i < kills_.size(); ++i) {
      const std::size_t index = FirstAfter(stream_ends_[i]);
      if (index == 0 || index == told_.size()) return absl::InternalError("no answer came");
      const Told& next = told_[index];
      Outcome& outcome = outcomes_.emplace_back();
      outcome.gap_s = std::chrono::duration<double>(next.time - kills_[i]).count();
      for (std::size_t k = index; k < told_.size(); ++k) {
        if (told_[k].result.state() == v1::LOCALIZATION_STATE_TRACKING) break;
        ++outcome.scans_until_tracking;
      }
      const v1::LocalizationResult& before = told_[index - 1].result;
      const Eigen::Vector2d jump = ErrorOf(next.result, truth_[index].T_map_vehicle) -
                                   ErrorOf(before, truth_[index - 1].T_map_vehicle);
      outcome.jump_m = jump.norm();
      const Eigen::Matrix2d covariance = CovarianceOf(next.result) + CovarianceOf(before);
      outcome.jump_sigmas = std::sqrt(jump.dot(covariance.inverse() * jump));
      const bool good = outcome.gap_s <= std::chrono::duration<double>(kMaxGap).count() &&
                        outcome.scans_until_tracking <= kMaxScansUntilTracking &&
                        outcome.jump_sigmas <= kMaxSigmas;
      if (!good) {
        return absl::InternalError(absl::StrFormat(
            "kill %d, at scan %d: %.3f s until the next answer, %d scans until TRACKING, a jump of "
            "%.3f m, %.2f sigma",
            outcomes_.size(), index, outcome.gap_s, outcome.scans_until_tracking, outcome.jump_m,
            outcome.jump_sigmas));
      }
    }
    return absl::OkStatus();
  }

  const Arguments arguments_;
  FailoverSite site_;
  const int scan_count_;
  std::vector<v1::Scan> scans_;
  std::vector<DriveScan> truth_;
  std::atomic<std::size_t> told_count_ = 0;
  std::mutex mutex_;
  std::vector<Told> told_;
  std::vector<Clock::time_point> kills_;
  std::vector<Clock::time_point> stream_ends_;
  std::vector<Outcome> outcomes_;
  client::SessionStats stats_;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Localizes a drive in real time while dcloc-server is killed again and again, and checks "
      "that another one goes on with the session");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--kills", arguments.kill_count, "Of the server that has the session")
      ->check(CLI::Range(1, 10'000));
  app.add_option("--rate", arguments.rate, "Of the drive, 1 is real time")
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--seed", arguments.seed, "Of the random moments");
  CLI11_PARSE(app, argc, argv);
  Campaign campaign(arguments);
  return RunCampaign(campaign, arguments.seed);
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::Main, argc, argv); }
