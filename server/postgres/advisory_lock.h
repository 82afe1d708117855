#pragma once

namespace dcloc::server {

/// The number, "DCLC", of this program's advisory locks in a database that it may share with
/// others; for the text of a statement.
inline constexpr char kAdvisoryLock[] = "1145261123";

}  // namespace dcloc::server
