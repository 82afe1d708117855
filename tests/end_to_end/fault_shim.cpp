// Makes one call of a process to the system fail, for `fault_campaign.py`. Loaded by LD_PRELOAD
// into a server. libfiu fails calls by name or by chance; here it must be the Nth one that works on
// a file of the store, or write half of what it was given, so that each can be tried in turn.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace {

enum Function : std::int32_t {
  kNone,
  kOpen,
  kRead,
  kWrite,
  kSync,
  kRename,
  kTruncate,
  kMap,
  kRemove,
  kMakeFolder
};

/// Shared with the campaign, in this order.
struct Control {
  std::atomic<std::int32_t> function;   ///< that is to fail
  std::atomic<std::int32_t> countdown;  ///< calls until then: 1 is the next one
  std::atomic<std::int32_t> error;      ///< errno; 0: half of what was asked for
  std::atomic<std::int32_t> hit_count;
};

template <typename Call>
Call Next(const char* name) {
  return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}

Control* OpenControl() {
  const char* path = std::getenv("DCLOC_FAULT_CONTROL");
  if (path == nullptr) return nullptr;
  const int file = Next<int (*)(const char*, int, ...)>("open")(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  using Map = void* (*)(void*, std::size_t, int, int, int, off_t);
  void* const memory =
      Next<Map>("mmap")(nullptr, sizeof(Control), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<Control*>(memory);
}

Control* TheControl() {
  static Control* const control = OpenControl();
  return control;
}

bool IsInStore(std::string_view path) {
  static const char* const folder = std::getenv("DCLOC_FAULT_FOLDER");
  return folder != nullptr && path.starts_with(folder);
}

bool IsInStore(int descriptor) {
  std::array<char, 64> link{};
  std::array<char, 4096> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", descriptor);
  const ssize_t size = readlink(link.data(), path.data(), path.size());
  return size > 0 && IsInStore(std::string_view(path.data(), static_cast<std::size_t>(size)));
}

/// Whether this call is the one to fail.
template <typename File>
bool Fails(Function function, File file) {
  Control* const control = TheControl();
  if (control == nullptr || control->function != function || !IsInStore(file)) return false;
  if (--control->countdown != 0) return false;
  ++control->hit_count;
  errno = control->error;
  return true;
}

/// The size with which a call that is to be cut short goes on; 0: it fails.
template <typename File>
std::size_t SizeFor(Function function, File file, std::size_t size) {
  if (!Fails(function, file)) return size;
  return TheControl()->error == 0 ? (size + 1) / 2 : 0;
}

}  // namespace

extern "C" {

#define DCLOC_OPEN(NAME)                                                                      \
  int NAME(const char* path, int flags, ...) {                                                \
    va_list arguments;                                                                        \
    va_start(arguments, flags);                                                               \
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0; \
    va_end(arguments);                                                                        \
    if (Fails(kOpen, std::string_view(path))) return -1;                                      \
    return Next<int (*)(const char*, int, ...)>(#NAME)(path, flags, mode);                    \
  }
DCLOC_OPEN(open)
DCLOC_OPEN(open64)

ssize_t read(int file, void* bytes, std::size_t size) {
  const std::size_t allowed = SizeFor(kRead, file, size);
  if (allowed == 0 && size > 0) return -1;
  return Next<ssize_t (*)(int, void*, std::size_t)>("read")(file, bytes, allowed);
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  const std::size_t allowed = SizeFor(kWrite, file, size);
  if (allowed == 0 && size > 0) return -1;
  return Next<ssize_t (*)(int, const void*, std::size_t)>("write")(file, bytes, allowed);
}

ssize_t pread64(int file, void* bytes, std::size_t size, off64_t offset) {
  const std::size_t allowed = SizeFor(kRead, file, size);
  if (allowed == 0 && size > 0) return -1;
  return Next<ssize_t (*)(int, void*, std::size_t, off64_t)>("pread64")(file, bytes, allowed,
                                                                        offset);
}

ssize_t pwrite64(int file, const void* bytes, std::size_t size, off64_t offset) {
  const std::size_t allowed = SizeFor(kWrite, file, size);
  if (allowed == 0 && size > 0) return -1;
  return Next<ssize_t (*)(int, const void*, std::size_t, off64_t)>("pwrite64")(file, bytes, allowed,
                                                                               offset);
}

int fsync(int file) { return Fails(kSync, file) ? -1 : Next<int (*)(int)>("fsync")(file); }

int fdatasync(int file) { return Fails(kSync, file) ? -1 : Next<int (*)(int)>("fdatasync")(file); }

int rename(const char* from, const char* to) {
  if (Fails(kRename, std::string_view(from))) return -1;
  return Next<int (*)(const char*, const char*)>("rename")(from, to);
}

int ftruncate64(int file, off64_t size) {
  if (Fails(kTruncate, file)) return -1;
  return Next<int (*)(int, off64_t)>("ftruncate64")(file, size);
}

int ftruncate(int file, off_t size) {
  if (Fails(kTruncate, file)) return -1;
  return Next<int (*)(int, off_t)>("ftruncate")(file, size);
}

void* mmap64(void* address, std::size_t size, int protection, int flags, int file, off64_t offset) {
  if (file >= 0 && Fails(kMap, file)) return MAP_FAILED;
  return Next<void* (*)(void*, std::size_t, int, int, int, off64_t)>("mmap64")(
      address, size, protection, flags, file, offset);
}

int unlink(const char* path) {
  if (Fails(kRemove, std::string_view(path))) return -1;
  return Next<int (*)(const char*)>("unlink")(path);
}

int remove(const char* path) {
  if (Fails(kRemove, std::string_view(path))) return -1;
  return Next<int (*)(const char*)>("remove")(path);
}

int mkdir(const char* path, mode_t mode) {
  if (Fails(kMakeFolder, std::string_view(path))) return -1;
  return Next<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}

}  // extern "C"
