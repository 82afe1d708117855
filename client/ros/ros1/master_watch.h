#pragma once

#include <atomic>
#include <thread>

namespace dcloc::node {

/// Notices that the master was started anew. It then knows of no topic, and roscpp does not tell
/// it. Asks on a thread of its own, since a master that is gone may take long to be found so.
class MasterWatch {
 public:
  MasterWatch();
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

  /// Whether another master has been found since the last call.
  bool TakeRestart() { return restarted_.exchange(false); }

 private:
  void Run();

  std::atomic<bool> restarted_{false};
  std::atomic<bool> ends_{false};
  std::thread thread_;  // last: it uses the others
};

}  // namespace dcloc::node
