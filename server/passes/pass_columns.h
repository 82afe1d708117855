#pragma once

#include <chrono>
#include <cstdint>

#include "server/passes/pass_rows.h"

/// How the columns of consents and passes are read and written, alike in all implementations.
namespace dcloc::server {

inline constexpr std::int64_t kDay_ns = 86'400'000'000'000;

inline std::int64_t NumberOf(ConsentSubject subject) { return static_cast<std::int64_t>(subject); }

inline std::int64_t NanosecondsOf(SystemTime time) { return time.time_since_epoch().count(); }

/// A row with all columns of `pass`.
template <typename Row>
PassRow NextPass(Row& row) {
  PassRow pass;
  pass.number = row.NextInteger();
  pass.pass_id = row.NextText();
  pass.tenant = row.NextText();
  pass.map_name = row.NextText();
  pass.map_version = row.NextInteger();
  pass.vehicle = row.NextText();
  pass.identity = row.NextText();
  pass.scan_count = row.NextInteger();
  pass.size_bytes = row.NextInteger();
  pass.first_stamp_ns = row.NextInteger();
  pass.last_stamp_ns = row.NextInteger();
  pass.sha256 = row.NextText();
  pass.create_time = SystemTime(std::chrono::nanoseconds(row.NextInteger()));
  pass.expire_time = SystemTime(std::chrono::nanoseconds(row.NextInteger()));
  return pass;
}

/// All columns but the number.
template <typename Values>
void BindPass(const PassRow& row, Values& insert) {
  insert.Bind(row.pass_id).Bind(row.tenant).Bind(row.map_name).Bind(row.map_version);
  insert.Bind(row.vehicle).Bind(row.identity).Bind(row.scan_count).Bind(row.size_bytes);
  insert.Bind(row.first_stamp_ns).Bind(row.last_stamp_ns).Bind(row.sha256);
  insert.Bind(NanosecondsOf(row.create_time)).Bind(NanosecondsOf(row.expire_time));
}

template <typename Row>
ConsentRow NextConsent(Row& row) {
  const auto subject = static_cast<ConsentSubject>(row.NextInteger());
  return {.subject = subject, .name = row.NextText()};
}

}  // namespace dcloc::server
