#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "client/sdk/session.h"
#include "tests/end_to_end/disturbed_drive.h"
#include "tests/end_to_end/run_program.h"
#include "tests/end_to_end/session_site.h"
#include "tests/server/fixtures/town_drive.h"

// A drive through a network that breaks again and again and a server that is restarted now and
// then: each scan is answered exactly once, no connection that breaks changes a bit of the track,
// and after each restart it goes on as a session does that begins at the last pose.
namespace dcloc {
namespace {

using Answers = std::vector<v1::LocalizeResponse>;

struct Arguments {
  std::string server;
  int scan_count = 1500;
  Disturbances disturbances = {.cut_count = 10, .restart_count = 2};
};

constexpr char kVehicle[] = "car-1";
/// How far two tracks of the same scans may be apart that began elsewhere.
constexpr double kMaxDistance_m = 0.5;

/// An answer without what a clock gives.
std::string Essence(v1::LocalizeResponse answer) {
  answer.clear_from_memory();
  if (answer.has_result()) answer.mutable_result()->clear_timings();
  return answer.SerializeAsString();
}

/// Where two lists of answers differ first; OK when they do not.
absl::Status Compare(const std::string& whose, const Answers& answers, const Answers& expected) {
  for (std::size_t i = 0; i < std::min(answers.size(), expected.size()); ++i) {
    if (Essence(answers[i]) == Essence(expected[i])) continue;
    return absl::InternalError(
        absl::StrFormat("%s: the answer to scan %d is another one", whose, NumberOf(answers[i])));
  }
  if (answers.size() == expected.size()) return absl::OkStatus();
  return absl::InternalError(
      absl::StrFormat("%s: %d answers instead of %d", whose, answers.size(), expected.size()));
}

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments)
      : arguments_(arguments), site_(arguments.server, kVehicle, SessionSite::Localizer::kMethod) {}

  absl::Status Run() {
    constexpr double kMetresPerScan = 0.84;  // 40 km/h, 13.4 Hz
    const server::TownDrive town(50.0 + kMetresPerScan * arguments_.scan_count);
    open_ = town.Open();
    scans_ = town.Scans();
    const auto scan_count = static_cast<std::size_t>(arguments_.scan_count);
    if (scans_.size() < scan_count) return absl::InternalError("the drive is too short");
    scans_.resize(scan_count);
    for (std::size_t i = 5; i < scans_.size(); i += 97) scans_[i].set_radar_id("nobody");
    if (absl::Status status = site_.Start(town.map); !status.ok()) return status;
    absl::StatusOr<Answers> undisturbed = DriveOnce(open_, "undisturbed", scans_);
    if (!undisturbed.ok()) return undisturbed.status();
    undisturbed_ = *std::move(undisturbed);
    absl::Status status = DriveWhileDisturbed();
    if (status.ok()) status = CheckSessions();
    if (status.ok()) status = CheckTrack();
    return status;
  }

  void Report() const {
    const client::SessionStats& stats = recoveries_.stats;
    absl::PrintF(
        "%d scans, %d cuts, %d restarts: %d streams broke, %d resumed, %d sessions; each scan was "
        "answered exactly once, and the answers of all sessions are those of undisturbed ones to "
        "the bit. %.1f %% of the scans are tracked (undisturbed %.1f %%), at most %.3f m from the "
        "undisturbed track\n",
        scans_.size(), arguments_.disturbances.cut_count, arguments_.disturbances.restart_count,
        stats.disconnect_count, stats.resume_count, stats.restart_count + 1,
        TrackedPercent(answers_), TrackedPercent(undisturbed_), max_distance_m_);
  }

 private:
  static DriveScans ScansOf(const std::vector<v1::Scan>& scans, Answers& answers) {
    return {
        .count = static_cast<int>(scans.size()),
        .at = [&scans](int index) { return scans[static_cast<std::size_t>(index)]; },
        .take = [&answers](v1::LocalizeResponse answer) { answers.push_back(std::move(answer)); }};
  }

  /// An undisturbed session with what another one was opened with.
  absl::StatusOr<Answers> DriveOnce(v1::OpenSession open, const std::string& vehicle_id,
                                    const std::vector<v1::Scan>& scans) const {
    open.set_vehicle_id(vehicle_id);
    client::SessionOptions options = CampaignOptions();
    options.reconnect = std::nullopt;
    const auto session = client::Session::Open(site_.Channel(), std::move(open), options);
    if (!session.ok()) return session.status();
    Answers answers;
    absl::Status status = DriveUndisturbed(**session, ScansOf(scans, answers));
    if (!status.ok()) return status;
    return answers;
  }

  absl::Status DriveWhileDisturbed() {
    v1::OpenSession open = open_;
    open.set_vehicle_id(kVehicle);
    const auto session = client::Session::Open(site_.Channel(), open, CampaignOptions());
    if (!session.ok()) return session.status();
    return DriveDisturbed(**session, ScansOf(scans_, answers_), site_, arguments_.disturbances,
                          recoveries_);
  }

  /// Each session that the server had is what an undisturbed one with its beginning and its scans
  /// is, the first one also what the whole undisturbed drive is, and all together are what the
  /// vehicle was told.
  absl::Status CheckSessions() {
    const auto sessions = site_.TakeRecordings();
    if (!sessions.ok()) return sessions.status();
    Answers told = undisturbed_;
    for (const RecordedSession& session : *sessions) {
      std::vector<v1::Scan> scans;
      Answers answers;
      for (const v1::RecordedScan& recorded : session.scans) {
        if (!answers.empty() && NumberOf(recorded.answer()) == NumberOf(answers.back())) {
          // The newest one was refused, and the connection broke before the vehicle heard of it:
          // nothing has come of it, so that it is judged again when it comes again.
          scans.pop_back();
          answers.pop_back();
        }
        scans.push_back(recorded.scan());
        answers.push_back(recorded.answer());
        // Of a scan whose answer was lost with its session, the next one's.
        told[static_cast<std::size_t>(NumberOf(recorded.answer()))] = recorded.answer();
      }
      const auto again = DriveOnce(session.header.open(), "again", scans);
      if (!again.ok()) return again.status();
      absl::Status status =
          Compare("a session and an undisturbed one with its scans", answers, *again);
      if (!status.ok()) return status;
      if (&session != &sessions->front()) continue;
      const Answers begin(undisturbed_.begin(),
                          undisturbed_.begin() + static_cast<std::ptrdiff_t>(answers.size()));
      status = Compare("the first session and the undisturbed drive", answers, begin);
      if (!status.ok()) return status;
    }
    return Compare("what the vehicle was told and what sessions answered", answers_, told);
  }

  absl::Status CheckTrack() {
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      const v1::LocalizationResult& a = answers_[i].result();
      const v1::LocalizationResult& b = undisturbed_[i].result();
      if (!IsTracked(answers_[i]) || !IsTracked(undisturbed_[i])) continue;
      const v1::Vector3& at = a.pose().pose().translation_m();
      const v1::Vector3& expected = b.pose().pose().translation_m();
      max_distance_m_ =
          std::max(max_distance_m_, std::hypot(at.x() - expected.x(), at.y() - expected.y()));
    }
    if (max_distance_m_ <= kMaxDistance_m) return absl::OkStatus();
    return absl::InternalError(
        absl::StrFormat("the tracks are up to %.3f m apart", max_distance_m_));
  }

  static bool IsTracked(const v1::LocalizeResponse& answer) {
    return answer.result().state() == v1::LOCALIZATION_STATE_TRACKING;
  }

  static double TrackedPercent(const Answers& answers) {
    return 100.0 * static_cast<double>(std::ranges::count_if(answers, &IsTracked)) /
           static_cast<double>(answers.size());
  }

  const Arguments arguments_;
  SessionSite site_;
  v1::OpenSession open_;
  std::vector<v1::Scan> scans_;
  Answers undisturbed_;
  Answers answers_;
  Recoveries recoveries_;
  double max_distance_m_ = 0.0;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Localizes a drive while connections break and dcloc-server is restarted, and checks that "
      "each scan is answered once and right");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--scans", arguments.scan_count, "Of the drive")->check(CLI::Range(100, 20'000));
  app.add_option("--cuts", arguments.disturbances.cut_count, "Of all connections")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--restarts", arguments.disturbances.restart_count, "Of the server, by SIGTERM")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--seed", arguments.disturbances.seed, "Of the random moments");
  CLI11_PARSE(app, argc, argv);
  Campaign campaign(arguments);
  return RunCampaign(campaign, arguments.disturbances.seed);
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::Main, argc, argv); }
