#pragma once

#include <cstdint>

namespace dcloc::client {

/// What a session went through.
struct SessionStats {
  std::int64_t disconnect_count = 0;     ///< streams that ended before the session did
  std::int64_t resume_count = 0;         ///< times that the session went on
  std::int64_t ticket_resume_count = 0;  ///< of these: at a server that knew only its ticket
  std::int64_t restart_count = 0;        ///< times that it had to begin anew
  std::int64_t lost_fix_count = 0;       ///< fixes that got no answer, as the connection broke
};

}  // namespace dcloc::client
