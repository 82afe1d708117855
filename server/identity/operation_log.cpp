#include "server/identity/operation_log.h"

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/status.h"
#include "server/identity/method_permissions.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// Requests above are not printed to be cut off.
constexpr std::size_t kMaxPrinted_bytes = 64 << 10;

std::string CutOff(std::string text) {
  if (text.size() > OperationLog::kMaxText) text.resize(OperationLog::kMaxText);
  return text;
}

}  // namespace

OperationLog::OperationLog() {
  const google::protobuf::DescriptorPool& pool =
      *google::protobuf::DescriptorPool::generated_pool();
  for (const MethodPermission& entry : MethodPermissions()) {
    if (entry.effect != Effect::kChanges) continue;
    const google::protobuf::MethodDescriptor* method = pool.FindMethodByName(entry.method);
    if (method != nullptr) method_of_.emplace(method->input_type(), entry.method);
  }
}

std::string OperationLog::TextOf(const google::protobuf::Message& request) {
  const std::size_t size_bytes = request.ByteSizeLong();
  if (size_bytes > kMaxPrinted_bytes) return absl::StrCat("a message of ", size_bytes, " bytes");
  return CutOff(request.ShortDebugString());  // escapes what is not printable
}

void OperationLog::Note(const grpc::ServerContextBase& context, const Principal& principal,
                        const google::protobuf::Message& request, const absl::Status& status) {
  const google::protobuf::Descriptor* type = request.GetDescriptor();
  if (method_of_.contains(type)) Note(context, principal, type, TextOf(request), status);
}

void OperationLog::Note(const grpc::ServerContextBase& context, const Principal& principal,
                        const google::protobuf::Descriptor* request, std::string text,
                        const absl::Status& status) {
  const auto method = method_of_.find(request);
  if (method == method_of_.end()) return;
  Operation operation{.time = std::chrono::system_clock::now(),
                      .principal = principal,
                      .peer = context.peer(),
                      .method = method->second,
                      .request = CutOff(std::move(text)),
                      .code = status.code(),
                      .message = CutOff(absl::CHexEscape(status.message()))};
  spdlog::info(
      "operation method={} principal={} role={} tenant={} peer={} code={} request=\"{}\" "
      "message=\"{}\"",
      operation.method, Quoted(principal.name), std::string(NameOf(principal.role)),
      Quoted(principal.tenant), operation.peer, absl::StatusCodeToString(operation.code),
      absl::CHexEscape(operation.request), operation.message);
  const std::lock_guard lock(mutex_);
  operation.number = ++last_number_;
  kept_.push_back(std::move(operation));
  if (kept_.size() > kMaxKept) DropOldestOfLargest();
}

void OperationLog::DropOldestOfLargest() {
  std::map<absl::string_view, int> count_of;
  for (const Operation& kept : kept_) ++count_of[kept.principal.tenant];
  const auto largest =
      std::ranges::max_element(count_of, {}, [](const auto& tenant) { return tenant.second; });
  kept_.erase(std::ranges::find_if(
      kept_, [&](const Operation& kept) { return kept.principal.tenant == largest->first; }));
}

std::vector<Operation> OperationLog::List(absl::string_view tenant, std::int64_t before,
                                          int limit) const {
  std::vector<Operation> list;
  const std::lock_guard lock(mutex_);
  for (auto operation = kept_.rbegin(); operation != kept_.rend(); ++operation) {
    if (static_cast<int>(list.size()) == limit) break;
    if (operation->number >= before || operation->principal.tenant != tenant) continue;
    list.push_back(*operation);
  }
  return list;
}

}  // namespace dcloc::server
