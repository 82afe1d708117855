#include "client/load/load_report.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc::load {
namespace {

using nlohmann::ordered_json;

ordered_json ToJson(const LatencyHistogram& histogram) {
  return {{"count", histogram.count()},           {"mean_ms", histogram.MeanMs()},
          {"p50_ms", histogram.QuantileMs(0.5)},  {"p90_ms", histogram.QuantileMs(0.9)},
          {"p99_ms", histogram.QuantileMs(0.99)}, {"p999_ms", histogram.QuantileMs(0.999)},
          {"max_ms", histogram.max_ms()}};
}

ordered_json ToJson(const Incidents& incidents) {
  return {{"count", incidents.count}, {"first", incidents.first}};
}

ordered_json ToJson(const LoadTotals& totals) {
  return {{"answered_count", totals.answered_count},
          {"repeated_count", totals.repeated_count},
          {"late_refused_count", totals.late_refused_count},
          {"dropped_count", totals.dropped_count},
          {"skipped_count", totals.skipped_count},
          {"lost_count", totals.lost_count},
          {"opened_count", totals.opened_count},
          {"moved_count", totals.moved_count},
          {"restart_count", totals.restart_count},
          {"disconnect_count", totals.disconnect_count},
          {"stall_count", totals.stall_count},
          {"tracking_count", totals.tracking_count},
          {"lost_state_count", totals.lost_state_count},
          {"judged_count", totals.judged_count},
          {"mean_error_m", totals.MeanErrorM()},
          {"max_error_m", totals.max_error_m},
          {"misleading_count", totals.misleading_count},
          {"refused", ToJson(totals.refused)},
          {"broken_streams", ToJson(totals.broken)},
          {"violations", ToJson(totals.violations)}};
}

ordered_json ToJson(const std::vector<LoadSecond>& seconds) {
  ordered_json list = ordered_json::array();
  for (const LoadSecond& second : seconds) {
    list.push_back({{"time_s", second.time_s},
                    {"vehicle_count", second.vehicle_count},
                    {"answered_count", second.answered_count},
                    {"p50_ms", second.p50_ms},
                    {"p99_ms", second.p99_ms},
                    {"max_ms", second.max_ms}});
  }
  return list;
}

std::string Number(double value) { return absl::StrFormat("%.2f", value); }

}  // namespace

ordered_json ToJson(const LoadResult& result, const std::vector<std::string>& shortfalls) {
  return {{"vehicle_count", result.vehicle_count},
          {"measured_s", result.measured_s},
          {"rate_hz", result.RateHz()},
          {"client_core_count", result.client_core_count},
          {"held", shortfalls.empty()},
          {"shortfalls", shortfalls},
          {"latency", ToJson(result.record.latency)},
          {"server_latency", ToJson(result.record.server_latency)},
          {"open_latency", ToJson(result.record.open_latency)},
          {"answer_gap", ToJson(result.record.gap)},
          {"totals", ToJson(result.record.totals)},
          {"seconds", ToJson(result.record.seconds)}};
}

std::vector<std::vector<std::string>> TableOf(const std::vector<const LoadResult*>& results) {
  std::vector<std::vector<std::string>> rows = {{"vehicles", "scans/s", "p50 [ms]", "p90", "p99",
                                                 "max", "server p99", "open p99", "lost",
                                                 "client cores"}};
  for (const LoadResult* result : results) {
    const LoadRecord& record = result->record;
    rows.push_back({absl::StrCat(result->vehicle_count), absl::StrFormat("%.0f", result->RateHz()),
                    Number(record.latency.QuantileMs(0.5)), Number(record.latency.QuantileMs(0.9)),
                    Number(record.latency.QuantileMs(0.99)), Number(record.latency.max_ms()),
                    Number(record.server_latency.QuantileMs(0.99)),
                    Number(record.open_latency.QuantileMs(0.99)),
                    absl::StrCat(record.totals.lost_count), Number(result->client_core_count)});
  }
  return rows;
}

std::vector<std::string> NotesOf(const LoadResult& result) {
  const LoadTotals& totals = result.record.totals;
  std::vector<std::string> notes = {
      absl::StrFormat("%d scans answered in %.1f s; %d sessions opened", totals.answered_count,
                      result.measured_s, totals.opened_count)};
  const auto add = [&](std::int64_t count, const char* what) {
    if (count > 0) notes.push_back(absl::StrCat(count, " ", what));
  };
  add(totals.moved_count, "times a session was moved to another map version");
  add(totals.restart_count, "sessions began anew, as their server was gone");
  add(totals.disconnect_count, "connections were broken on purpose");
  add(totals.stall_count, "stalls were made on purpose");
  add(totals.repeated_count, "answers came again from memory");
  add(totals.late_refused_count, "scans behind their follower were refused as late");
  if (totals.judged_count > 0) {
    notes.push_back(absl::StrFormat(
        "%d tracking answers are off the truth by %.3f m in the mean, %.3f m at most; %d mislead",
        totals.judged_count, totals.MeanErrorM(), totals.max_error_m, totals.misleading_count));
  }
  return notes;
}

std::string LineOf(const LoadSecond& second) {
  return absl::StrFormat("%4.0f s: %d vehicles, %d scans/s, p50 %.1f ms, p99 %.1f ms, max %.1f ms",
                         second.time_s, second.vehicle_count, second.answered_count, second.p50_ms,
                         second.p99_ms, second.max_ms);
}

Picture LatencyPicture(const LoadResult& result) {
  std::string commands = "$seconds << EOD\n";
  for (const LoadSecond& second : result.record.seconds) {
    absl::StrAppendFormat(&commands, "%.3f %.3f %.3f %.3f %d\n", second.time_s, second.p50_ms,
                          second.p99_ms, second.max_ms, second.answered_count);
  }
  absl::StrAppendFormat(
      &commands,
      "EOD\n"
      "set multiplot layout 2,1 title '%d vehicles, %.0f scans/s: p50 %.2f ms, p99 %.2f ms'\n"
      "set grid\nset key top left\nset xrange [0:*]\n"
      "set logscale y\nset ylabel 'latency [ms]'\n"
      "plot $seconds using 1:4 with lines title 'max', '' using 1:3 with lines title 'p99', "
      "'' using 1:2 with lines title 'p50'\n"
      "unset logscale y\nset yrange [0:*]\nset ylabel 'scans/s'\nset xlabel 'time [s]'\n"
      "plot $seconds using 1:5 with lines notitle\n"
      "unset multiplot\n",
      result.vehicle_count, result.RateHz(), result.record.latency.QuantileMs(0.5),
      result.record.latency.QuantileMs(0.99));
  return {.commands = commands};
}

}  // namespace dcloc::load
