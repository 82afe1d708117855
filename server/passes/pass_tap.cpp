#include "server/passes/pass_tap.h"

#include <utility>

#include "core/passes/beyond_map.h"
#include "core/radar/stamp.h"
#include "server/base/framed_file.h"
#include "server/base/within_memory.h"
#include "server/passes/pass_file.h"

namespace dcloc::server {
namespace {

/// That is handed over at once: some seconds of a session.
constexpr std::size_t kChunk_bytes = std::size_t{256} << 10;

}  // namespace

PassTap::PassTap(PassWriter& writer, NewPass pass, const v1::Rig& rig)
    : writer_(writer), new_pass_(std::move(pass)) {
  v1::PassHeader header;
  header.set_format_version(kPassFormatVersion);
  *header.mutable_rig() = rig;
  AppendFramed(header, &header_);
}

PassTap::~PassTap() {
  WithinMemory([this] { EndPass(); }).IgnoreError();
}

void PassTap::OnLocalized(const v1::Scan& scan, const LocalizedScan& answer) {
  const absl::Status taken = WithinMemory([&] { Consider(scan, answer); });
  if (!taken.ok()) pass_.reset();  // what it has may not be whole
}

void PassTap::Consider(const v1::Scan& scan, const LocalizedScan& answer) {
  const std::chrono::nanoseconds gap(scan.stamp_ns() - last_stamp_ns_);
  if (pass_ != nullptr && (answer.map_version != new_pass_.map_version || gap > kMaxGap ||
                           pass_bytes_ > kMaxPass_bytes)) {
    EndPass();
  }
  if (!IsWanted(scan, answer)) {
    ++writer_.counts().unworthy_scans;
    return;
  }
  if (pass_ == nullptr) BeginPass(answer.map_version);
  Take(scan, answer);
  if (chunk_.bytes.size() >= kChunk_bytes && !HandOver()) EndPass();
}

/// A scan that counts; or one of a pass whose vehicle goes on beyond the map, as far as an update
/// follows it there.
bool PassTap::IsWanted(const v1::Scan& scan, const LocalizedScan& answer) {
  const ScanWorth worth = WorthOf(scan, answer);
  const Eigen::Vector3d& p_map_m = answer.localization.T_map_vehicle.translation_m;
  if (worth == ScanWorth::kGood) {
    good_stamp_ns_ = scan.stamp_ns();
    good_p_map_m_ = p_map_m;
    return true;
  }
  return pass_ != nullptr && worth != ScanWorth::kUnsound &&
         std::chrono::nanoseconds(scan.stamp_ns() - good_stamp_ns_) <= kMaxBeyond &&
         (p_map_m - good_p_map_m_).norm() <= BeyondMapOptions().max_way_m;
}

/// A stub knows nothing of its radars' health, and so none of its scans counts.
ScanWorth PassTap::WorthOf(const v1::Scan& scan, const LocalizedScan& answer) {
  if (answer.rig == nullptr || answer.rig->Find(scan.radar_id()) == nullptr) {
    return ScanWorth::kUnsound;
  }
  const std::size_t radar = answer.rig->IndexOf(scan.radar_id());
  if (radar >= answer.localization.health.radars.size()) return ScanWorth::kUnsound;
  return judge_.Judge(answer.localization, radar, Stamp(std::chrono::nanoseconds(scan.stamp_ns())));
}

void PassTap::BeginPass(std::int64_t map_version) {
  new_pass_.map_version = map_version;
  pass_ = writer_.Begin(new_pass_);
  chunk_ = {.bytes = header_};
  pass_bytes_ = static_cast<std::int64_t>(header_.size());
}

void PassTap::Take(const v1::Scan& scan, const LocalizedScan& answer) {
  *entry_.mutable_scan() = scan;
  v1::LocalizationResult* const result = entry_.mutable_result();
  convert::ToProto(answer.localization, result);
  convert::ToProto(answer.localization.health, *answer.rig, result->mutable_health());
  const std::size_t before = chunk_.bytes.size();
  AppendFramed(entry_, &chunk_.bytes);
  pass_bytes_ += static_cast<std::int64_t>(chunk_.bytes.size() - before);
  if (chunk_.scan_count++ == 0) chunk_.first_stamp_ns = scan.stamp_ns();
  chunk_.last_stamp_ns = scan.stamp_ns();
  last_stamp_ns_ = scan.stamp_ns();
}

bool PassTap::HandOver() { return writer_.Append(pass_, std::exchange(chunk_, {})); }

void PassTap::EndPass() {
  if (pass_ == nullptr) return;
  if (chunk_.scan_count > 0) HandOver();
  writer_.End(pass_);
  pass_.reset();
  chunk_ = {};
}

}  // namespace dcloc::server
