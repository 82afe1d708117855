#include "server/passes/pass_writer.h"

#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/random_name.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

class PassWriter::Pass {
 public:
  explicit Pass(NewPass begun) : pass(std::move(begun)) {}
  ~Pass() {
    if (!path.empty()) RemoveFile(path).IgnoreError();
  }

  NewPass pass;
  std::filesystem::path path;  ///< empty before the first chunk
  std::ofstream out;
  Sha256 hash;
  bool failed = false;
};

PassWriter::PassWriter(PassStore& store, std::filesystem::path folder,
                       std::function<PassBounds()> bounds)
    : store_(store),
      folder_(std::move(folder)),
      bounds_(std::move(bounds)),
      thread_([this] { Run(); }) {}

PassWriter::~PassWriter() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

std::shared_ptr<PassWriter::Pass> PassWriter::Begin(NewPass pass) {
  return std::make_shared<Pass>(std::move(pass));
}

bool PassWriter::Append(const std::shared_ptr<Pass>& pass, PassChunk chunk) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_bytes_ + chunk.bytes.size() > kMaxWaiting_bytes) {
      counts_.dropped_scans += chunk.scan_count;
      return false;
    }
    waiting_bytes_ += chunk.bytes.size();
    counts_.taken_scans += chunk.scan_count;
    waiting_.push_back({.pass = pass, .chunk = std::move(chunk)});
  }
  wake_.notify_one();
  return true;
}

void PassWriter::End(const std::shared_ptr<Pass>& pass) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({.pass = pass, .is_end = true});
  }
  wake_.notify_one();
}

void PassWriter::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Item item = std::move(waiting_.front());
    waiting_.pop_front();
    waiting_bytes_ -= item.chunk.bytes.size();
    lock.unlock();
    const absl::Status done =
        WithinMemory([&] { item.is_end ? Finish(*item.pass) : Write(*item.pass, item.chunk); });
    if (!done.ok()) item.pass->failed = true;
    lock.lock();
  }
}

void PassWriter::Write(Pass& pass, const PassChunk& chunk) const {
  if (pass.failed) return;
  if (pass.path.empty()) {
    const absl::StatusOr<std::string> name = RandomName(64, "a pass");
    pass.failed = !name.ok();
    if (pass.failed) return;
    pass.path = folder_ / absl::StrCat("pass-", *name);
    pass.out.open(pass.path, std::ios::binary | std::ios::trunc);
    pass.pass.first_stamp_ns = chunk.first_stamp_ns;
  }
  pass.out.write(chunk.bytes.data(), static_cast<std::streamsize>(chunk.bytes.size()));
  pass.failed = !pass.out;
  pass.hash.Update(std::as_bytes(std::span(chunk.bytes)));
  pass.pass.last_stamp_ns = chunk.last_stamp_ns;
  pass.pass.scan_count += chunk.scan_count;
  pass.pass.size_bytes += static_cast<std::int64_t>(chunk.bytes.size());
}

void PassWriter::Finish(Pass& pass) {
  if (!pass.failed && pass.pass.scan_count < kMinScanCount) {
    ++counts_.too_short;
    return;
  }
  pass.out.close();
  if (pass.failed || !pass.out) {
    return Count(absl::InternalError("the pass cannot be written: the disk may be full"));
  }
  pass.pass.sha256 = pass.hash.Finish();
  const absl::Status status = store_.Add(pass.pass, pass.path, bounds_());
  Count(status);
  if (!status.ok()) return;
  spdlog::info("pass kept tenant={} map={} version={} scans={}", pass.pass.tenant,
               pass.pass.map_name, pass.pass.map_version, pass.pass.scan_count);
}

void PassWriter::Count(const absl::Status& status) {
  if (status.ok()) {
    ++counts_.kept;
    return;
  }
  if (absl::IsPermissionDenied(status)) {
    ++counts_.withdrawn;
  } else if (absl::IsResourceExhausted(status)) {
    ++counts_.over_quota;
  } else {
    ++counts_.failed;
  }
  spdlog::info("pass not kept reason={}", Quoted(status.message()));
}

}  // namespace dcloc::server
