#include "client/cli/dataset/inspect_text.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "client/cli/common/terminal.h"
#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kOtherClock_s = 1.0;  ///< so late comes no message that is of the same clock
constexpr double kGapOfIntervals = 2.5;

double Seconds(Stamp first, Stamp last) {
  return std::chrono::duration<double>(last - first).count();
}

std::int64_t Nanoseconds(Stamp stamp) { return stamp.time_since_epoch().count(); }

std::string TimeText(Stamp stamp) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%E3S UTC", absl::FromUnixNanos(Nanoseconds(stamp)),
                          absl::UTCTimeZone());
}

/// By the stamps where there are some, else by when messages came.
double Rate_hz(const BagTopic& topic) {
  const bool has_stamps = topic.stamps.count > 1;
  const double duration_s = has_stamps ? Seconds(topic.stamps.first, topic.stamps.last)
                                       : Seconds(topic.first_record, topic.last_record);
  if (duration_s <= 0.0) return 0.0;
  const std::int64_t count = has_stamps ? topic.stamps.count : topic.message_count;
  return static_cast<double>(count - 1) / duration_s;
}

std::string SummaryText(const std::string& name, const BagOverview& overview) {
  const rosbag::BagSummary& summary = overview.summary;
  std::string text = absl::StrCat(Visible(name), ": ", summary.message_count, " messages");
  if (!summary.compressions.empty()) {
    absl::StrAppend(&text, ", packed with ", absl::StrJoin(summary.compressions, ", "));
  }
  if (!overview.topics.empty()) {
    const Stamp first = std::ranges::min(overview.topics, {}, &BagTopic::first_record).first_record;
    const Stamp last = std::ranges::max(overview.topics, {}, &BagTopic::last_record).last_record;
    absl::StrAppendFormat(&text, ", recorded in %.1f s from %s", Seconds(first, last),
                          TimeText(first));
  }
  if (summary.is_cut()) {
    absl::StrAppend(&text, "\ncut off at byte ", summary.cut_at,
                    ": what lies before is read (`rosbag reindex` mends it for ROS's own tools)");
  } else if (!summary.has_index) {
    text += "\nwithout index, which is not needed here (`rosbag reindex` makes one)";
  }
  return text + "\n";
}

/// What is odd about a topic's stamps, a line each.
std::string StampText(const BagTopic& topic) {
  const BagStamps& stamps = topic.stamps;
  std::string text;
  const std::string name = Visible(topic.connection.topic);
  if (stamps.backward_count > 0) {
    absl::StrAppend(&text, name, ": ", stamps.backward_count, " stamps go back in time\n");
  }
  if (stamps.repeated_count > 0) {
    absl::StrAppend(&text, name, ": ", stamps.repeated_count,
                    " stamps are that of the message "
                    "before\n");
  }
  if (stamps.least_delay_s > kOtherClock_s || stamps.greatest_delay_s < -kOtherClock_s) {
    absl::StrAppendFormat(&text,
                          "%s: its stamps are %.3f s %s the recorder's clock; are they of another "
                          "clock?\n",
                          name, std::abs(stamps.least_delay_s),
                          stamps.least_delay_s > 0.0 ? "before" : "after");
  }
  return text;
}

std::string DelayText(const BagStamps& stamps) {
  if (stamps.count == 0) return "-";
  return absl::StrFormat("%.0f to %.0f", 1e3 * stamps.least_delay_s, 1e3 * stamps.greatest_delay_s);
}

const char* SourceText(PoseSource source) {
  switch (source) {
    case PoseSource::kReference:
      return "reference";
    case PoseSource::kOdometry:
      return "odometry";
    case PoseSource::kNone:
      return "none";
  }
  return "unknown";
}

const char* MeaningName(RangeRateMeaning meaning) {
  switch (meaning) {
    case RangeRateMeaning::kUnknown:
      return "unknown";
    case RangeRateMeaning::kAway:
      return "away";
    case RangeRateMeaning::kTowards:
      return "towards";
    case RangeRateMeaning::kCompensated:
      return "compensated";
    case RangeRateMeaning::kAwayMirrored:
      return "away_mirrored";
    case RangeRateMeaning::kTowardsMirrored:
      return "towards_mirrored";
    case RangeRateMeaning::kOfAnotherMount:
      return "of_another_mount";
    case RangeRateMeaning::kNothingFits:
      return "nothing_fits";
  }
  return "unknown";
}

std::size_t VelocityCount(const std::vector<ScanStatistics>& statistics) {
  std::size_t count = 0;
  for (const ScanStatistics& radar : statistics) count += radar.velocity_count;
  return count;
}

std::string RadarText(const RadarModel& radar, const ScanStatistics& statistics,
                      const RangeRateCheck& check) {
  const Eigen::Vector3d& t = radar.T_vehicle_radar.translation_m;
  std::string text = absl::StrFormat(
      "radar %s: at x %.2f, y %.2f, z %.2f m, yaw %.1f deg; beta %g s%s\n", Visible(radar.id),
      t.x(), t.y(), t.z(), Yaw(radar.T_vehicle_radar.rotation) * kDegPerRad, radar.beta_s,
      radar.has_elevation ? "; with elevation" : "");
  if (statistics.scan_count == 0) return text + "  no scans\n";
  absl::StrAppendFormat(
      &text, "  %d scans, %.1f Hz, %.0f targets each", statistics.scan_count, statistics.Rate_hz(),
      static_cast<double>(statistics.target_count) / static_cast<double>(statistics.scan_count));
  if (statistics.empty_count > 0) absl::StrAppend(&text, ", ", statistics.empty_count, " empty");
  if (statistics.longest_gap_s > kGapOfIntervals * statistics.median_interval_s) {
    absl::StrAppendFormat(&text, ", longest gap %.2f s", statistics.longest_gap_s);
  }
  absl::StrAppend(&text, "\n  range rates are ", Visible(MeaningText(check)));
  if (check.target_count == 0) return text + "\n";
  absl::StrAppendFormat(&text, " (%.0f %% of %d targets that tell)\n", 100.0 * check.best_share,
                        check.target_count);
  return text;
}

}  // namespace

std::string OverviewText(const std::string& name, const BagOverview& overview) {
  std::vector<std::vector<std::string>> rows = {
      {"topic", "type", "messages", "Hz", "delay [ms]", "frame"}};
  std::string details;
  std::string odd;
  for (const BagTopic& topic : overview.topics) {
    const double rate_hz = Rate_hz(topic);
    rows.push_back({topic.connection.topic, topic.connection.type,
                    absl::StrCat(topic.message_count),
                    rate_hz > 0.0 ? absl::StrFormat("%.1f", rate_hz) : "-", DelayText(topic.stamps),
                    topic.frame.empty() ? "-" : topic.frame});
    if (!topic.fields.empty()) {
      absl::StrAppend(&details, "fields of ", Visible(topic.connection.topic), ": ",
                      Visible(absl::StrJoin(topic.fields, " ")), "\n");
    }
    if (!topic.fault.empty()) {
      absl::StrAppend(&odd, Visible(topic.connection.topic), " is not read: ", Visible(topic.fault),
                      "\n");
    }
    odd += StampText(topic);
  }
  return absl::StrCat(SummaryText(name, overview), FormatTable(rows), details, odd);
}

ordered_json OverviewJson(const BagOverview& overview) {
  ordered_json topics = ordered_json::array();
  for (const BagTopic& topic : overview.topics) {
    ordered_json entry = {{"topic", topic.connection.topic},
                          {"type", topic.connection.type},
                          {"message_count", topic.message_count},
                          {"rate_hz", Rate_hz(topic)},
                          {"first_record_ns", Nanoseconds(topic.first_record)},
                          {"last_record_ns", Nanoseconds(topic.last_record)},
                          {"frame", topic.frame},
                          {"fields", topic.fields},
                          {"fault", topic.fault}};
    if (topic.stamps.count > 0) {
      entry["stamps"] = {{"first_ns", Nanoseconds(topic.stamps.first)},
                         {"last_ns", Nanoseconds(topic.stamps.last)},
                         {"backward_count", topic.stamps.backward_count},
                         {"repeated_count", topic.stamps.repeated_count},
                         {"longest_gap_s", topic.stamps.longest_gap_s},
                         {"least_delay_s", topic.stamps.least_delay_s},
                         {"greatest_delay_s", topic.stamps.greatest_delay_s}};
    }
    topics.push_back(std::move(entry));
  }
  const rosbag::BagSummary& summary = overview.summary;
  ordered_json json = {{"message_count", summary.message_count},
                       {"has_index", summary.has_index},
                       {"is_cut", summary.is_cut()},
                       {"compressions", summary.compressions}};
  if (summary.is_cut()) json["cut_at"] = summary.cut_at;
  json["topics"] = std::move(topics);
  return json;
}

std::string MappingText(const BagMapping& mapping) {
  return BagMappingJson(mapping).dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string DriveText(const Drive& drive, const std::vector<ScanStatistics>& statistics,
                      const std::vector<RangeRateCheck>& checks) {
  const Stamp first = drive.scans.front().scan.stamp;
  std::string text = absl::StrFormat(
      "drive %s: %d scans in %.1f s from %s; %d of them with a velocity of the vehicle; poses: "
      "%s\n",
      Visible(drive.name), drive.scans.size(), Seconds(first, drive.scans.back().scan.stamp),
      TimeText(first), VelocityCount(statistics), SourceText(drive.pose_source));
  for (std::size_t i = 0; i < checks.size(); ++i) {
    text += RadarText(drive.rig.radars[i], statistics[i], checks[i]);
  }
  return text;
}

ordered_json DriveJson(const Drive& drive, const std::vector<ScanStatistics>& statistics,
                       const std::vector<RangeRateCheck>& checks) {
  ordered_json radars = ordered_json::array();
  for (std::size_t i = 0; i < checks.size(); ++i) {
    const RangeRateCheck& check = checks[i];
    const ScanStatistics& scans = statistics[i];
    radars.push_back({{"id", check.radar_id},
                      {"scan_count", scans.scan_count},
                      {"target_count", scans.target_count},
                      {"rate_hz", scans.Rate_hz()},
                      {"longest_gap_s", scans.longest_gap_s},
                      {"range_rates", MeaningName(check.meaning)},
                      {"meaning", MeaningText(check)},
                      {"telling_target_count", check.target_count},
                      {"fitting_share", check.fitting_share},
                      {"best_share", check.best_share}});
  }
  return {{"name", drive.name},
          {"scan_count", drive.scans.size()},
          {"first_stamp_ns", Nanoseconds(drive.scans.front().scan.stamp)},
          {"last_stamp_ns", Nanoseconds(drive.scans.back().scan.stamp)},
          {"velocity_count", VelocityCount(statistics)},
          {"poses", SourceText(drive.pose_source)},
          {"notes", drive.notes},
          {"radars", std::move(radars)}};
}

}  // namespace dcloc::cli
