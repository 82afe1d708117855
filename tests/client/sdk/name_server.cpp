#include "tests/client/sdk/name_server.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <stdexcept>

namespace dcloc::client {
namespace {

constexpr int kNamePoll_ms = 20;
constexpr std::size_t kHeader_bytes = 12;
constexpr char kServerFailure = 2;

/// The end of the question that follows the header: a name, its type and its class.
std::size_t EndOfQuestion(const std::string& message) {
  std::size_t end = kHeader_bytes;
  while (end < message.size() && message[end] != '\0') {
    end += 1 + static_cast<std::uint8_t>(message[end]);
  }
  return end + 5;
}

}  // namespace

NameServer::NameServer() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  if (bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("no port for the name server");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Run(); });
}

NameServer::~NameServer() {
  stopping_ = true;
  thread_.join();
  close(socket_);
}

std::string NameServer::Target(int port) const {
  return "dns://127.0.0.1:" + std::to_string(port_) + "/maps.dcloc.example:" + std::to_string(port);
}

void NameServer::Run() {
  while (!stopping_) {
    pollfd entry{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&entry, 1, kNamePoll_ms) <= 0) continue;
    std::array<char, 512> buffer{};
    sockaddr_in peer{};
    socklen_t size = sizeof(peer);
    const ssize_t received = recvfrom(socket_, buffer.data(), buffer.size(), 0,
                                      reinterpret_cast<sockaddr*>(&peer), &size);
    if (received < static_cast<ssize_t>(kHeader_bytes)) continue;
    ++question_count_;
    if (mood_ == Mood::kSilent) continue;
    const std::string answer =
        AnswerTo(std::string(buffer.data(), static_cast<std::size_t>(received)));
    sendto(socket_, answer.data(), answer.size(), 0, reinterpret_cast<sockaddr*>(&peer), size);
  }
}

/// RFC 1035, 4.1. Only a question for an IPv4 address has something in its answer.
std::string NameServer::AnswerTo(const std::string& question) const {
  const std::size_t end = EndOfQuestion(question);
  if (end > question.size()) return {};
  std::string answer = question.substr(0, end);
  answer[2] = static_cast<char>(0x80 | (question[2] & 1));  // an answer; recursion as wanted
  answer[3] = static_cast<char>(0x80);
  for (std::size_t count = 6; count < kHeader_bytes; ++count) answer[count] = '\0';
  if (mood_ == Mood::kFails) {
    answer[3] = static_cast<char>(answer[3] | kServerFailure);
    return answer;
  }
  const bool asks_for_ipv4 = question[end - 4] == 0 && question[end - 3] == 1;
  if (!asks_for_ipv4) return answer;
  answer[7] = 1;
  // The question's name, type A, class IN, to be kept for no time, 4 bytes.
  answer += std::string("\xc0\x0c\0\1\0\1\0\0\0\0\0\4\x7f\0\0", 15);
  answer += static_cast<char>(last_byte_);
  return answer;
}

}  // namespace dcloc::client
