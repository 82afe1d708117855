#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"

namespace dcloc {

/// Keeps what is finished under its name, so that an interrupted campaign goes on where it was.
template <typename Result>
class ResultStore {
 public:
  virtual ~ResultStore() = default;
  virtual std::optional<Result> Load(const std::string& name) = 0;
  virtual absl::Status Save(const std::string& name, const Result& result) = 0;
};

}  // namespace dcloc
