#include "client/ros/ros1/ros_parameters.h"

#include "absl/strings/str_cat.h"

namespace dcloc::node {
namespace {

absl::StatusOr<ParameterValue> ValueOf(const std::string& name, XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return ParameterValue(static_cast<bool>(value));
    case XmlRpc::XmlRpcValue::TypeInt:
      return ParameterValue(static_cast<double>(static_cast<int>(value)));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return ParameterValue(static_cast<double>(value));
    case XmlRpc::XmlRpcValue::TypeString:
      return ParameterValue(static_cast<std::string>(value));
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("~", name, " is a list or a struct; it must be one value"));
  }
}

}  // namespace

absl::StatusOr<std::map<std::string, ParameterValue>> ReadParameters(
    const ::ros::NodeHandle& node) {
  std::map<std::string, ParameterValue> parameters;
  XmlRpc::XmlRpcValue all;
  if (!node.getParam(node.getNamespace(), all)) return parameters;
  if (all.getType() != XmlRpc::XmlRpcValue::TypeStruct) return parameters;
  for (auto& [name, value] : all) {
    absl::StatusOr<ParameterValue> taken = ValueOf(name, value);
    if (!taken.ok()) return taken.status();
    parameters[name] = *std::move(taken);
  }
  return parameters;
}

}  // namespace dcloc::node
