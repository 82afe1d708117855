#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>

#include "core/options/option_fields.h"

namespace dcloc {

// Sets a field to a number; a duration to so many milliseconds. False where it cannot hold it.
template <typename Options>
bool SetField(Options& options, const OptionField<Options>& field, double value) {
  return std::visit(
      [&](auto pointer) {
        auto& member = options.*pointer;
        using Member = std::remove_reference_t<decltype(member)>;
        if constexpr (!std::is_same_v<Member, double>) {
          if (std::isnan(value)) return false;
        }
        if constexpr (std::is_same_v<Member, std::size_t>) {
          if (value < 0.0) return false;
        }
        if constexpr (std::is_same_v<Member, std::chrono::nanoseconds>) {
          member = std::chrono::milliseconds(static_cast<int>(value));
        } else {
          member = static_cast<Member>(value);
        }
        return true;
      },
      field.member);
}

// Expects that the defaults are valid; that `Validate` names each field that is NaN or -1, and
// that zero is refused or explained.
template <typename Options>
void ExpectEachFieldIsBounded() {
  using ::testing::StartsWith;
  EXPECT_TRUE(Validate(Options()).ok()) << Validate(Options());
  for (const OptionField<Options>& field : FieldsOf(Options())) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), -1.0}) {
      Options options;
      if (!SetField(options, field, value)) continue;
      EXPECT_THAT(std::string(Validate(options).message()), StartsWith(field.name)) << value;
    }
    Options options;
    ASSERT_TRUE(SetField(options, field, 0.0));
    const std::string message(ValidateFields(options, FieldsOf(options)).message());
    if (field.min > 0.0) {
      EXPECT_THAT(message, StartsWith(field.name));
    } else {
      EXPECT_EQ(message, "");
      EXPECT_STRNE(field.zero, "") << field.name << ": say what zero means";
    }
  }
}

}  // namespace dcloc
