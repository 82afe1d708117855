#pragma once

#include <memory>
#include <string>
#include <vector>

namespace dcloc::server {

/// The servers that share a catalogue, as each of them says of itself. Thread-safe.
class ReplicaDirectory {
 public:
  virtual ~ReplicaDirectory() = default;

  /// This server can be reached by the others at `address`, HOST:PORT, until the directory goes.
  virtual void Announce(const std::string& address) = 0;

  /// The addresses of the others, in ascending order: known without waiting, and while the database
  /// is away as they were. One that has died is among them until its lease has ended.
  virtual std::vector<std::string> Others() const = 0;
};

}  // namespace dcloc::server
