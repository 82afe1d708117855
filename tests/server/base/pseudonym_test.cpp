#include "server/base/pseudonym.h"

#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

const std::string kKey(32, 'k');

TEST(PseudonymTest, IsTheSameForTheSamePartsAndKeyAlone) {
  const std::string name = Pseudonym(kKey, {"vehicle", "acme", "car-1"});
  EXPECT_EQ(name.size(), 32U);
  EXPECT_EQ(Pseudonym(kKey, {"vehicle", "acme", "car-1"}), name);
  EXPECT_NE(Pseudonym(std::string(32, 'x'), {"vehicle", "acme", "car-1"}), name);
  EXPECT_NE(Pseudonym(kKey, {"identity", "acme", "car-1"}), name);
}

TEST(PseudonymTest, PartsDoNotRunTogether) {
  EXPECT_NE(Pseudonym(kKey, {"a", "bc"}), Pseudonym(kKey, {"ab", "c"}));
  EXPECT_NE(Pseudonym(kKey, {"a 1 b"}), Pseudonym(kKey, {"a", "b"}));
}

}  // namespace
}  // namespace dcloc::server
