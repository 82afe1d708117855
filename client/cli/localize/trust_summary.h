#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::cli {

/// What a session's answers say beside the poses: sources that were set aside, jumps, protection
/// levels, and what became of position fixes.
class TrustSummary {
 public:
  /// A line for people where something has changed since the answer before; else empty.
  std::string Add(const v1::LocalizationResult& result);

  void Add(const v1::PositionFixAnswer& answer);

  /// For people; empty where there is nothing to say.
  std::string Text() const;

  nlohmann::ordered_json Json() const;

 private:
  std::int64_t answer_count_ = 0;
  std::int64_t reset_count_ = 0;
  std::string set_aside_;                                 ///< of the last answer
  std::map<std::string, std::int64_t> set_aside_counts_;  ///< answers, by source and fault
  std::vector<double> protection_levels_m_;
  std::map<std::string, std::int64_t> fix_counts_;  ///< by use
  std::string first_invalid_fix_;
};

}  // namespace dcloc::cli
