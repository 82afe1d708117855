#include "server/net/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "absl/strings/numbers.h"

namespace dcloc::server {

bool NotifyServiceManager(absl::string_view state) {
  const char* path = std::getenv("NOTIFY_SOCKET");
  if (path == nullptr) return true;
  const std::size_t size = std::strlen(path);
  sockaddr_un address{};
  if (size == 0 || size >= sizeof(address.sun_path)) return false;
  address.sun_family = AF_UNIX;
  std::copy_n(path, size, address.sun_path);
  if (path[0] == '@') address.sun_path[0] = '\0';  // the abstract namespace
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const ssize_t sent = sendto(fd, state.data(), state.size(), MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address),
                              static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size));
  close(fd);
  return sent == static_cast<ssize_t>(state.size());
}

std::optional<std::chrono::microseconds> WatchdogInterval() {
  const char* text = std::getenv("WATCHDOG_USEC");
  const char* pid = std::getenv("WATCHDOG_PID");
  std::int64_t interval_us = 0;
  std::int64_t wanted_pid = 0;
  if (text == nullptr || !absl::SimpleAtoi(text, &interval_us) || interval_us <= 0) return {};
  // It may be meant for another process that passed its environment on.
  if (pid != nullptr && (!absl::SimpleAtoi(pid, &wanted_pid) || wanted_pid != getpid())) return {};
  return std::chrono::microseconds(interval_us);
}

}  // namespace dcloc::server
