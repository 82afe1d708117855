#pragma once

namespace dcloc::server {

/// Lets one allocation of the server's own code fail, as long as it lives: the one after
/// `skipped_count` others. The server's own is what dcloc's code asks for, by itself or through the
/// libraries of C++, absl and protobuf, on any thread but the one that made this. What gRPC asks
/// for never fails: it would end the process, which has a reserve for that (`MemoryReserve`).
class FailingAllocation {
 public:
  explicit FailingAllocation(int skipped_count);
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  ~FailingAllocation();

  /// Whether it has failed.
  static bool HasFailed();
};

}  // namespace dcloc::server
