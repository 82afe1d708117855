#include "server/telemetry/http_pages.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::seconds kMaxTime(1);
/// How exactly it is kept.
constexpr int kPollTimeout_ms = 100;
constexpr std::size_t kMaxConnections = 256;
constexpr std::size_t kMaxRequest_bytes = 8192;
constexpr absl::string_view kEndOfHeaders = "\r\n\r\n";

bool IsWhole(absl::string_view request) { return absl::StrContains(request, kEndOfHeaders); }

bool WouldBlock() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

absl::StatusOr<std::unique_ptr<HttpPages>> HttpPages::Serve(const ListenAddress& address,
                                                            absl::string_view setting,
                                                            std::vector<HttpPage> pages) {
  absl::StatusOr<ListenSockets> listening = BindListenSockets(address, setting);
  if (!listening.ok()) return listening.status();
  FileDescriptor wake(eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return absl::ErrnoToStatus(errno, "eventfd");
  ListenAddress bound = address;
  bound.port = listening->port;
  return std::unique_ptr<HttpPages>(
      new HttpPages(*std::move(listening), std::move(wake), bound.ToString(), std::move(pages)));
}

HttpPages::HttpPages(ListenSockets listening, FileDescriptor wake, std::string address,
                     std::vector<HttpPage> pages)
    : listening_(std::move(listening)),
      wake_(std::move(wake)),
      address_(std::move(address)),
      pages_(std::move(pages)),
      thread_([this] { Run(); }) {}

HttpPages::~HttpPages() {
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

void HttpPages::Run() {
  bool goes_on = true;
  while (goes_on) {
    const absl::Status status = WithinMemory([&] {
      goes_on = WaitForPeers();
      if (goes_on) AnswerAll();
    });
    if (!status.ok()) connections_.clear();  // they may ask again
  }
}

void HttpPages::AnswerAll() {
  const Clock::time_point now = Clock::now();
  for (Connection& connection : connections_) {
    if (connection.state != State::kReading || now < connection.deadline) continue;
    connection.state = State::kAsking;
  }
  Answer();
  connections_.remove_if([now](const Connection& connection) {
    return connection.state == State::kDone || now >= connection.deadline;
  });
}

/// Moves all that need not wait, and accepts new ones; false when it is to stop.
bool HttpPages::WaitForPeers() {
  std::vector<pollfd> wanted = {{.fd = wake_.get(), .events = POLLIN, .revents = 0}};
  for (const FileDescriptor& socket : listening_.sockets) {
    wanted.push_back({.fd = socket.get(), .events = POLLIN, .revents = 0});
  }
  bool asks = false;
  for (const Connection& connection : connections_) {
    asks |= connection.state == State::kAsking;
    const short events = connection.state == State::kReading   ? POLLIN
                         : connection.state == State::kWriting ? POLLOUT
                                                               : short{0};
    wanted.push_back({.fd = connection.socket.get(), .events = events, .revents = 0});
  }
  const int timeout_ms = asks ? 0 : connections_.empty() ? -1 : kPollTimeout_ms;
  if (poll(wanted.data(), wanted.size(), timeout_ms) < 0) return true;
  if (wanted[0].revents != 0) return false;
  auto event = wanted.begin() + 1 + static_cast<std::ptrdiff_t>(listening_.sockets.size());
  for (Connection& connection : connections_) Move(connection, (event++)->revents);
  for (std::size_t i = 1; i <= listening_.sockets.size(); ++i) {
    if (wanted[i].revents != 0) Accept(wanted[i].fd);
  }
  return true;
}

/// All that wait, so that who comes last is not behind those that come all the time.
void HttpPages::Accept(int listening_fd) {
  for (std::size_t i = 0; i < kMaxConnections; ++i) {
    FileDescriptor socket(accept4(listening_fd, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) return;
    if (connections_.size() == kMaxConnections) connections_.pop_front();
    connections_.push_back({.socket = std::move(socket), .deadline = Clock::now() + kMaxTime});
    // Its request is often there already.
    Read(connections_.back());
  }
}

void HttpPages::Move(Connection& connection, short events) {
  if (events == 0) return;
  if (connection.state == State::kReading) Read(connection);
  if (connection.state == State::kWriting) Write(connection);
}

void HttpPages::Read(Connection& connection) {
  std::array<char, kMaxRequest_bytes> buffer{};
  const ssize_t size = recv(connection.socket.get(), buffer.data(), buffer.size(), 0);
  if (size < 0 && WouldBlock()) return;
  if (size > 0) connection.request.append(buffer.data(), static_cast<std::size_t>(size));
  if (size > 0 && !IsWhole(connection.request) && connection.request.size() < kMaxRequest_bytes)
    return;
  connection.state = State::kAsking;
}

void HttpPages::Write(Connection& connection) {
  const absl::string_view rest =
      absl::string_view(connection.response).substr(connection.sent_bytes);
  const ssize_t size = send(connection.socket.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
  if (size < 0 && WouldBlock()) return;
  connection.sent_bytes += size > 0 ? static_cast<std::size_t>(size) : 0;
  if (size > 0 && connection.sent_bytes < connection.response.size()) return;
  shutdown(connection.socket.get(), SHUT_WR);
  connection.state = State::kDone;
}

/// Answers all that takes no time, and one page that does.
void HttpPages::Answer() {
  const auto is_urgent = [this](const Connection& connection) {
    const HttpPage* page = PageOf(connection);
    return page == nullptr || page->is_urgent;
  };
  Connection* first = nullptr;
  for (Connection& connection : connections_) {
    if (connection.state != State::kAsking) continue;
    if (is_urgent(connection)) {
      const HttpPage* page = PageOf(connection);
      Answer(connection, page == nullptr ? HttpAnswer{"404 Not Found", "metrics are at /metrics\n"}
                                         : page->make());
    } else if (first == nullptr) {
      first = &connection;
    }
  }
  if (first != nullptr) Answer(*first, PageOf(*first)->make());
}

void HttpPages::Answer(Connection& connection, HttpAnswer answer) {
  if (!IsWhole(connection.request))
    answer = {"400 Bad Request", ""};
  else if (!absl::StartsWith(connection.request, "GET "))
    answer = {"405 Method Not Allowed", ""};
  connection.response = absl::StrCat("HTTP/1.1 ", answer.status,
                                     "\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8"
                                     "\r\nConnection: close\r\nContent-Length: ",
                                     answer.body.size(), kEndOfHeaders, answer.body);
  connection.state = State::kWriting;
  connection.deadline = Clock::now() + kMaxTime;
  Write(connection);
}

const HttpPage* HttpPages::PageOf(const Connection& connection) const {
  const absl::string_view request = connection.request;
  if (!IsWhole(connection.request) || !absl::StartsWith(request, "GET ")) return nullptr;
  const absl::string_view path = request.substr(4, request.find_first_of(" ?\r", 4) - 4);
  const auto page = std::ranges::find(pages_, path, &HttpPage::path);
  return page == pages_.end() ? nullptr : &*page;
}

}  // namespace dcloc::server
