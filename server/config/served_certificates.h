#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/config/certificates.h"

namespace dcloc::server {

/// The certificates that a running server shows: the last good ones of its files. Bad ones are
/// never shown; `State::fault` reports them. Thread-safe.
class ServedCertificates {
 public:
  struct State {
    SystemTime expire_time;  ///< of the ones that are shown
    std::string fault;       ///< why the files' are not shown; empty: they are
  };

  /// InvalidArgument says what is wrong with the files.
  static absl::StatusOr<std::shared_ptr<ServedCertificates>> Load(const ServerConfig& config,
                                                                  SystemTime now);

  /// Takes new files, if they are good. Files are looked at twice before they are judged, so as not
  /// to judge half of a change. To be called every second or so, by one thread.
  void Refresh(SystemTime now);

  /// What is shown.
  std::shared_ptr<const CertificateFiles> files() const;

  State state() const;

 private:
  ServedCertificates(const ServerConfig& config, CertificateFiles files, SystemTime expire_time);

  void Take(const absl::StatusOr<CertificateFiles>& found, SystemTime now);
  void TakeFault(const absl::Status& status);

  const ServerConfig config_;

  mutable std::mutex mutex_;
  std::shared_ptr<const CertificateFiles> files_;
  State state_;

  absl::StatusOr<CertificateFiles> last_look_;  ///< the refreshing thread's
};

}  // namespace dcloc::server
