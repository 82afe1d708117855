#pragma once

#include <Eigen/Core>
#include <chrono>
#include <memory>
#include <string>

#include "core/passes/scan_worth.h"
#include "dcloc/v1/pass_service.pb.h"
#include "server/convert/answer.h"
#include "server/passes/pass_writer.h"

namespace dcloc::server {

/// Hands what is worth it of a session's scans to the writer, as passes: a gap of more than a
/// second, another version of the map and a length of `kMaxPass_bytes` begin another one. A pass
/// goes on where the vehicle leaves the map, as that may be a new street. Waits for nothing. Not
/// thread-safe.
class PassTap {
 public:
  static constexpr std::chrono::seconds kMaxGap{1};
  static constexpr std::chrono::minutes kMaxBeyond{2};  ///< after the last scan that counts
  static constexpr std::int64_t kMaxPass_bytes = std::int64_t{16} << 20;

  /// `pass` says whose they are. `writer` outlives it.
  PassTap(PassWriter& writer, NewPass pass, const v1::Rig& rig);
  /// The session has ended.
  ~PassTap();
  PassTap(const PassTap&) = delete;
  PassTap& operator=(const PassTap&) = delete;

  /// `scan` is as it was sent. Without memory for it, the pass is dropped.
  void OnLocalized(const v1::Scan& scan, const LocalizedScan& answer);

 private:
  void Consider(const v1::Scan& scan, const LocalizedScan& answer);
  bool IsWanted(const v1::Scan& scan, const LocalizedScan& answer);
  ScanWorth WorthOf(const v1::Scan& scan, const LocalizedScan& answer);
  void BeginPass(std::int64_t map_version);
  void Take(const v1::Scan& scan, const LocalizedScan& answer);
  /// False when the writer is behind: then the pass ends with what it has.
  bool HandOver();
  void EndPass();

  PassWriter& writer_;
  NewPass new_pass_;
  std::string header_;  ///< of each pass's file
  ScanJudge judge_{ScanWorthOptions()};
  std::shared_ptr<PassWriter::Pass> pass_;  ///< null between passes
  std::int64_t pass_bytes_ = 0;
  std::int64_t last_stamp_ns_ = 0;
  std::int64_t good_stamp_ns_ = 0;  ///< of the last scan that counts
  Eigen::Vector3d good_p_map_m_ = Eigen::Vector3d::Zero();
  PassChunk chunk_;
  v1::PassEntry entry_;  ///< kept for its columns' memory
};

}  // namespace dcloc::server
