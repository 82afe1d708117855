#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace dcloc::client {

/// A name server on a free UDP port of this machine that knows every name, and that a test can take
/// away.
class NameServer {
 public:
  enum class Mood {
    kAnswers,
    kFails,   ///< says SERVFAIL
    kSilent,  ///< takes questions, and says nothing
  };

  NameServer();
  ~NameServer();
  NameServer(const NameServer&) = delete;
  NameServer& operator=(const NameServer&) = delete;

  void SetMood(Mood mood) { mood_ = mood; }

  /// Every name has the address 127.0.0.`last_byte`.
  void SetAddress(int last_byte) { last_byte_ = last_byte; }

  /// What gRPC dials to reach `port` of a machine whose name it asks this server for.
  std::string Target(int port) const;

  int question_count() const { return question_count_; }

 private:
  void Run();
  std::string AnswerTo(const std::string& question) const;

  int socket_ = -1;
  int port_ = 0;
  std::atomic<Mood> mood_ = Mood::kAnswers;
  std::atomic<int> last_byte_ = 1;
  std::atomic<int> question_count_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace dcloc::client
