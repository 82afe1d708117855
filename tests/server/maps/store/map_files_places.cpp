#include <filesystem>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/maps/store/cached_map_files.h"
#include "server/maps/store/map_bucket.h"
#include "server/maps/store/map_folder.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/places.h"
#include "tests/server/fixtures/s3_stub.h"

namespace dcloc::server {
namespace {

absl::string_view TextIn(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class FolderPlace : public MapFilesPlace {
 public:
  std::unique_ptr<MapFiles> Open() override { return OpenAs(""); }

  void Spoil(const std::string& sha256, std::span<const std::byte> bytes) override {
    const auto path = MapFolder::PathIn("maps", sha256).generic_string();
    folder_.Write(path, bytes);
  }

 protected:
  std::unique_ptr<MapFiles> OpenAs(const std::string& copier) const {
    return *MapFolder::Open(folder_.path() / "maps", folder_.path() / "quarantine", copier);
  }

 private:
  TemporaryFolder folder_;
};

class SharedFolderPlace final : public FolderPlace {
 public:
  std::unique_ptr<MapFiles> Open() override { return OpenAs(absl::StrCat("host:", ++count_)); }

 private:
  int count_ = 0;
};

class BucketPlace : public MapFilesPlace {
 public:
  std::unique_ptr<MapFiles> Open() override {
    return std::make_unique<MapBucket>(*ObjectStore::Open(stub_.Options()));
  }

  void Spoil(const std::string& sha256, std::span<const std::byte> bytes) override {
    stub_.Put(MapFolder::PathIn("site/maps", sha256).generic_string(), TextIn(bytes));
  }

 private:
  S3Stub stub_;
};

/// With a cache for each process.
class CachedBucketPlace final : public BucketPlace {
 public:
  std::unique_ptr<MapFiles> Open() override {
    const auto folder = folder_.path() / absl::StrCat(++count_);
    return std::make_unique<CachedMapFiles>(BucketPlace::Open(),
                                            *MapCache::Open(folder, std::int64_t{1} << 30));
  }

 private:
  TemporaryFolder folder_;
  int count_ = 0;
};

template <typename Place>
std::unique_ptr<MapFilesPlace> Make() {
  return std::make_unique<Place>();
}

}  // namespace

std::vector<MapFilesImplementation> MapFilesImplementations() {
  return {{"Folder", true, &Make<FolderPlace>},
          {"SharedFolder", true, &Make<SharedFolderPlace>},
          {"Bucket", true, &Make<BucketPlace>},
          {"CachedBucket", true, &Make<CachedBucketPlace>}};
}

}  // namespace dcloc::server
