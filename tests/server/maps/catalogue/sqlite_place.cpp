#include "server/maps/catalogue/sqlite_catalogue.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/places.h"

namespace dcloc::server {
namespace {

class SqlitePlace final : public CataloguePlace {
 public:
  std::unique_ptr<Catalogue> Open() override {
    return *SqliteCatalogue::Open(folder_.path() / "catalogue.sqlite");
  }

 private:
  TemporaryFolder folder_;
};

std::unique_ptr<CataloguePlace> MakePlace() { return std::make_unique<SqlitePlace>(); }

}  // namespace

std::vector<CatalogueImplementation> CatalogueImplementations() {
  return {{"Sqlite", true, &MakePlace}};
}

}  // namespace dcloc::server
