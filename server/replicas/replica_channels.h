#pragma once

#include <grpcpp/channel.h>

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace dcloc::server {

/// How this server proves itself to the others, and they to it: PEM files.
struct ReplicaTls {
  bool enabled = false;  ///< the servers listen with TLS
  std::string ca;        ///< authority of the others' certificates
  std::string cert;      ///< shown to the others; empty: none
  std::string key;
};

/// Connections to the other servers, made when they are needed and kept. Thread-safe.
class ReplicaChannels {
 public:
  explicit ReplicaChannels(ReplicaTls tls) : tls_(std::move(tls)) {}

  /// The channel to HOST:PORT. It is made anew when the files have changed; errors of reading them
  /// name the file.
  absl::StatusOr<std::shared_ptr<grpc::Channel>> To(const std::string& address);

  /// Lets go of those to servers that are not among `addresses`, ascending: they are gone. Calls
  /// that are under way keep theirs.
  void KeepOnly(const std::vector<std::string>& addresses);

  /// How many there are.
  std::size_t count() const;

 private:
  struct Files {
    std::string ca, cert, key;
    bool operator==(const Files&) const = default;
  };

  absl::StatusOr<Files> ReadFiles() const;

  const ReplicaTls tls_;
  mutable std::mutex mutex_;
  Files files_;  ///< that the channels are made with
  std::map<std::string, std::shared_ptr<grpc::Channel>> channels_;
};

}  // namespace dcloc::server
