#include <gtest/gtest.h>

#include "server/base/sqlite.h"
#include "server/identity/sqlite_identity_store.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/places.h"

namespace dcloc::server {
namespace {

class SqlitePlace final : public IdentityPlace {
 public:
  std::unique_ptr<IdentityStore> Open() override { return *SqliteIdentityStore::Open(path_); }

  void SpoilRole(std::int64_t id) override {
    absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path_);
    ASSERT_TRUE(database.ok()) << database.status();
    SqliteStatement update(*database, "UPDATE identity SET role = 'root' WHERE id = ?");
    ASSERT_TRUE(update.Bind(id).Run().ok());
  }

 private:
  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "identities.sqlite";
};

std::unique_ptr<IdentityPlace> MakePlace() { return std::make_unique<SqlitePlace>(); }

}  // namespace

std::vector<IdentityImplementation> IdentityImplementations() {
  return {{"Sqlite", true, &MakePlace}};
}

}  // namespace dcloc::server
