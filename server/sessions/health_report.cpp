#include "server/sessions/health_report.h"

#include "server/sessions/session_log.h"

namespace dcloc::server {

void HealthReport::OnLocalized(const LocalizedScan& scan, HealthWatch::Clock::time_point now) {
  const Localization& localization = scan.localization;
  info_->health.Set(localization.health, scan.rig);
  info_->pose_reset_count = localization.resets.count;
  const HealthChanges changes = watch_.Observe(localization.health, localization.resets, now);
  metrics_.ObserveHealth(changes);
  for (const SourceChange& change : changes.sources) LogSource(*info_, *scan.rig, change);
  if (changes.reset_is_logged) LogReset(*info_, localization.resets);
}

}  // namespace dcloc::server
