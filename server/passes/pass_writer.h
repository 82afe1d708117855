#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "server/base/sha256.h"
#include "server/passes/pass_counts.h"
#include "server/passes/pass_store.h"

namespace dcloc::server {

/// A part of a pass: bytes of its file, and what they hold.
struct PassChunk {
  std::string bytes;
  std::int64_t scan_count = 0;
  std::int64_t first_stamp_ns = 0;
  std::int64_t last_stamp_ns = 0;
};

/// Writes passes to files on a thread of its own, and has them kept. What waits for it is bounded:
/// whoever hands it something never waits, and is told when it is behind. Thread-safe.
class PassWriter {
 public:
  /// Bytes that may wait.
  static constexpr std::size_t kMaxWaiting_bytes = std::size_t{32} << 20;
  /// A pass of fewer scans tells too little.
  static constexpr std::int64_t kMinScanCount = 50;

  /// Files that are not whole are in `folder`; `bounds` is asked when a pass is kept.
  PassWriter(PassStore& store, std::filesystem::path folder, std::function<PassBounds()> bounds);
  /// Keeps what was handed over.
  ~PassWriter();
  PassWriter(const PassWriter&) = delete;
  PassWriter& operator=(const PassWriter&) = delete;

  /// One pass that is being written. Its members are the writer's thread's.
  class Pass;

  std::shared_ptr<Pass> Begin(NewPass pass);

  /// False: too much waits, and the chunk is dropped.
  bool Append(const std::shared_ptr<Pass>& pass, PassChunk chunk);

  /// The pass is whole.
  void End(const std::shared_ptr<Pass>& pass);

  PassStore& store() { return store_; }
  PassCounts& counts() { return counts_; }

 private:
  struct Item {
    std::shared_ptr<Pass> pass;
    PassChunk chunk;
    bool is_end = false;
  };

  void Run();
  void Write(Pass& pass, const PassChunk& chunk) const;
  void Finish(Pass& pass);
  void Count(const absl::Status& status);

  PassStore& store_;
  const std::filesystem::path folder_;
  const std::function<PassBounds()> bounds_;
  PassCounts counts_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool stopping_ = false;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::server
