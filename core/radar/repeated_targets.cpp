#include "core/radar/repeated_targets.h"

#include <algorithm>

#include "core/radar/scan_fingerprint.h"

namespace dcloc {

bool RepeatedTargets::OnScan(std::size_t index, const Scan& scan) {
  if (scan.size() < kMinTargetCount) return false;
  Sent& sent = radars_[index];
  const std::uint64_t fingerprint = FingerprintOfTargets(scan);
  const auto end =
      sent.fingerprints.begin() + static_cast<std::ptrdiff_t>(std::min(sent.count, kScanCount));
  if (std::find(sent.fingerprints.begin(), end, fingerprint) != end) return true;
  sent.fingerprints[sent.count++ % kScanCount] = fingerprint;
  return false;
}

}  // namespace dcloc
