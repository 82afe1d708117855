#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/sdk/pose/timeline.h"

namespace dcloc::client {

/// How far the smooth poses are from the others: `p + shift + turn x (p - centre)`, which goes back
/// to zero from `stamp_ns` on.
struct SmoothOffset {
  std::int64_t stamp_ns = 0;
  Vector3 centre_m{};
  Vector3 shift_m{};
  Vector3 turn_rad{};
};

/// What is told besides the segments.
struct TimelineHead {
  std::int64_t segment_count = 0;
  std::int64_t end_ns = 0;  ///< the last stamp that is answered
  SmoothOffset offset;
};

/// A timeline that one thread at a time replaces and any number of threads look into, at the same
/// time and without waiting. There are three copies: the writer fills the oldest one and then says
/// that it is the newest. A reader looks again if the writer came round to its copy meanwhile.
class PublishedTimeline {
 public:
  /// Of longer timelines the newest part is published.
  static constexpr std::size_t kMaxSegments = 160;

  /// What a reader finds at a stamp.
  struct Found {
    TimelineHead head;
    std::int64_t begin_ns = 0;       ///< of the first segment
    std::optional<Segment> segment;  ///< the last one that does not begin after the stamp
  };

  /// For one thread at a time.
  void Publish(const std::vector<Segment>& segments, TimelineHead head);

  Found Find(std::int64_t stamp_ns) const;

 private:
  static constexpr std::uint64_t kCopies = 3;

  /// A plain struct as words. Each is stored by release and loaded by acquire, so that a reader
  /// which sees one of a later timeline also sees that there is one.
  template <typename T>
  class Words {
   public:
    void Store(const T& value) {
      const auto words = std::bit_cast<std::array<std::uint64_t, kCount>>(value);
      for (std::size_t i = 0; i < kCount; ++i) words_[i].store(words[i], std::memory_order_release);
    }
    T Load() const {
      std::array<std::uint64_t, kCount> words;
      for (std::size_t i = 0; i < kCount; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      return std::bit_cast<T>(words);
    }

   private:
    static constexpr std::size_t kCount = sizeof(T) / sizeof(std::uint64_t);
    std::array<std::atomic<std::uint64_t>, kCount> words_{};
  };

  struct Copy {
    Words<TimelineHead> head;
    std::array<std::atomic<std::int64_t>, kMaxSegments> begins_ns{};
    std::array<Words<Segment>, kMaxSegments> segments;
  };

  static Found FindIn(const Copy& copy, std::int64_t stamp_ns);

  std::unique_ptr<std::array<Copy, kCopies>> copies_ =
      std::make_unique<std::array<Copy, kCopies>>();
  std::atomic<std::uint64_t> count_{0};  ///< of timelines so far; the newest is in the copy of that
};

}  // namespace dcloc::client
