#include "client/rosbag/message_types.h"

#include <algorithm>
#include <array>

#include "absl/strings/str_cat.h"

namespace dcloc::rosbag {
namespace {

constexpr std::array kTypes = {kPointCloud2,  kOdometry,
                               kTwistStamped, kTwistWithCovarianceStamped,
                               kPoseStamped,  kPoseWithCovarianceStamped,
                               kImu,          kNavSatFix,
                               kTf2,          kTf};

// The definitions without their comments, which do not count for the checksum.
constexpr const char* kHeaderPart = "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
constexpr const char* kPointFieldPart =
    "sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\n"
    "uint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\n"
    "uint32 offset\nuint8 datatype\nuint32 count\n";
constexpr const char* kVector3Part = "geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr const char* kQuaternionPart =
    "geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
constexpr const char* kTwistPart = "geometry_msgs/Twist\nVector3 linear\nVector3 angular\n";
constexpr const char* kTwistWithCovariancePart =
    "geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n";
constexpr const char* kPointPart = "geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr const char* kPosePart = "geometry_msgs/Pose\nPoint position\nQuaternion orientation\n";
constexpr const char* kPoseWithCovariancePart =
    "geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n";
constexpr const char* kDiagnosticStatusPart =
    "diagnostic_msgs/DiagnosticStatus\nbyte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
    "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values\n";
constexpr const char* kKeyValuePart = "diagnostic_msgs/KeyValue\nstring key\nstring value\n";
constexpr const char* kTransformPart =
    "geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n";
constexpr const char* kTransformStampedPart =
    "geometry_msgs/TransformStamped\nHeader header\nstring child_frame_id\nTransform transform\n";

std::string Join(const char* type, std::initializer_list<const char*> parts) {
  std::string definition = type;
  for (const char* part : parts) {
    absl::StrAppend(&definition, std::string(80, '='), "\nMSG: ", part);
  }
  return definition;
}

}  // namespace

std::span<const MessageType> KnownTypes() { return kTypes; }

const MessageType* FindType(absl::string_view name) {
  const auto* const found =
      std::ranges::find_if(kTypes, [&](const MessageType& type) { return name == type.name; });
  return found == kTypes.end() ? nullptr : found;
}

std::string DefinitionOf(const MessageType& type) {
  const absl::string_view name = type.name;
  if (name == kPointCloud2.name) {
    return Join(
        "Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\n"
        "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        {kHeaderPart, kPointFieldPart});
  }
  if (name == kTwistWithCovarianceStamped.name) {
    return Join("Header header\ngeometry_msgs/TwistWithCovariance twist\n",
                {kHeaderPart, kTwistWithCovariancePart, kTwistPart, kVector3Part});
  }
  if (name == kPoseWithCovarianceStamped.name) {
    return Join("Header header\nPoseWithCovariance pose\n",
                {kHeaderPart, kPoseWithCovariancePart, kPosePart, kPointPart, kQuaternionPart});
  }
  if (name == kOdometry.name) {
    return Join(
        "Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
        "geometry_msgs/TwistWithCovariance twist\n",
        {kHeaderPart, kPoseWithCovariancePart, kPosePart, kPointPart, kQuaternionPart,
         kTwistWithCovariancePart, kTwistPart, kVector3Part});
  }
  if (name == kDiagnosticArray.name) {
    return Join("Header header\nDiagnosticStatus[] status\n",
                {kHeaderPart, kDiagnosticStatusPart, kKeyValuePart});
  }
  if (name == kTf2.name) {
    return Join(
        "geometry_msgs/TransformStamped[] transforms\n",
        {kTransformStampedPart, kHeaderPart, kTransformPart, kVector3Part, kQuaternionPart});
  }
  return "";
}

}  // namespace dcloc::rosbag
