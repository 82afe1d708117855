#include "server/config/served_certificates.h"

#include <utility>

#include "absl/strings/escaping.h"

#include "spdlog/spdlog.h"

namespace dcloc::server {
absl::StatusOr<std::shared_ptr<ServedCertificates>> ServedCertificates::Load(
    const ServerConfig& config, SystemTime now) {
  absl::StatusOr<CertificateFiles> files = ReadCertificateFiles(config);
  if (!files.ok()) return files.status();
  const absl::StatusOr<SystemTime> expire_time = CheckCertificates(config, *files, now);
  if (!expire_time.ok()) return expire_time.status();
  return std::shared_ptr<ServedCertificates>(
      new ServedCertificates(config, *std::move(files), *expire_time));
}

ServedCertificates::ServedCertificates(const ServerConfig& config, CertificateFiles files,
                                       SystemTime expire_time)
    : config_(config),
      files_(std::make_shared<const CertificateFiles>(files)),
      state_{.expire_time = expire_time, .fault = ""},
      last_look_(std::move(files)) {}

void ServedCertificates::Refresh(SystemTime now) {
  absl::StatusOr<CertificateFiles> found = ReadCertificateFiles(config_);
  if (found == last_look_) Take(found, now);
  last_look_ = std::move(found);
}

void ServedCertificates::Take(const absl::StatusOr<CertificateFiles>& found, SystemTime now) {
  if (!found.ok()) return TakeFault(found.status());
  if (*found == *files()) return TakeFault(absl::OkStatus());
  const absl::StatusOr<SystemTime> expire_time = CheckCertificates(config_, *found, now);
  if (!expire_time.ok()) return TakeFault(expire_time.status());
  {
    const std::lock_guard lock(mutex_);
    files_ = std::make_shared<const CertificateFiles>(*found);
    state_ = {.expire_time = *expire_time, .fault = ""};
  }
  spdlog::info("certificate shown expires={}", DateText(*expire_time));
}

void ServedCertificates::TakeFault(const absl::Status& status) {
  const State before = state();
  if (before.fault == status.message()) return;
  {
    const std::lock_guard lock(mutex_);
    state_.fault = std::string(status.message());
  }
  if (status.ok()) {
    spdlog::info("certificate files are good again expires={}", DateText(before.expire_time));
  } else {
    spdlog::error("certificate not taken reason=\"{}\" shown_expires={}",
                  absl::CHexEscape(status.message()), DateText(before.expire_time));
  }
}

std::shared_ptr<const CertificateFiles> ServedCertificates::files() const {
  const std::lock_guard lock(mutex_);
  return files_;
}

ServedCertificates::State ServedCertificates::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

}  // namespace dcloc::server
