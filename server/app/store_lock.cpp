#include "server/app/store_lock.h"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <span>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::milliseconds kLookInterval(200);

/// What a lock file says. It is opened anew: a network file system asks its server then.
struct Notice {
  std::string name;
  timespec change{};

  bool operator==(const Notice& other) const {
    return name == other.name && change.tv_sec == other.change.tv_sec &&
           change.tv_nsec == other.change.tv_nsec;
  }
};

absl::StatusOr<Notice> ReadNotice(const std::filesystem::path& path) {
  const absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) return file.status();
  std::array<char, 512> text{};
  const absl::StatusOr<std::size_t> size = ReadUpTo(*file, std::as_writable_bytes(std::span(text)));
  if (!size.ok()) return size.status();
  struct stat state {};
  if (fstat(file->get(), &state) != 0) return absl::ErrnoToStatus(errno, "fstat");
  return Notice{.name = std::string(text.data(), *size), .change = state.st_mtim};
}

absl::Status CheckNoOtherHost(const std::filesystem::path& path, const std::string& host) {
  const absl::StatusOr<Notice> first = ReadNotice(path);
  if (!first.ok()) return first.status();
  // One of this host that has ended has left its name; the lock itself would tell a living one.
  if (first->name.empty() || absl::StartsWith(first->name, host + ":")) return absl::OkStatus();
  const auto end = std::chrono::steady_clock::now() + StoreLock::kPatience;
  while (std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kLookInterval);
    const absl::StatusOr<Notice> now = ReadNotice(path);
    if (!now.ok()) return now.status();
    if (*now == *first) continue;
    return absl::FailedPreconditionError(absl::StrCat(path.string(), " is held by another server, ",
                                                      Quoted(now->name),
                                                      "; one folder serves one process"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<StoreLock> StoreLock::Take(const std::filesystem::path& path,
                                          const std::string& host) {
  absl::StatusOr<FileDescriptor> file = LockFile(path);
  if (!file.ok()) return file.status();
  if (absl::Status status = CheckNoOtherHost(path, host); !status.ok()) return status;
  const std::string name = absl::StrCat(host, ":", getpid());
  absl::Status status = Truncate(*file, 0);
  if (status.ok()) status = WriteAll(*file, std::as_bytes(std::span(name)));
  if (!status.ok()) return status;
  return StoreLock(*std::move(file));
}

StoreLock::StoreLock(FileDescriptor file)
    : file_(std::make_shared<const FileDescriptor>(std::move(file))),
      beat_(std::make_unique<Ticker>(kBeat, [held = file_] { futimens(held->get(), nullptr); })) {}

StoreLock::~StoreLock() {
  if (file_ == nullptr) return;
  beat_.reset();
  // Who comes next need not wait.
  Truncate(*file_, 0).IgnoreError();
}

}  // namespace dcloc::server
