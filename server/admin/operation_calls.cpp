#include "server/admin/operation_calls.h"

#include <limits>
#include <string>

#include "server/convert/page.h"
#include "server/convert/time.h"

namespace dcloc::server {
namespace {

void Describe(const Operation& operation, v1::Operation* message) {
  message->set_number(operation.number);
  *message->mutable_time() = convert::ToProto(operation.time);
  message->set_principal(operation.principal.name);
  message->set_role(std::string(NameOf(operation.principal.role)));
  message->set_peer(operation.peer);
  message->set_method(operation.method);
  message->set_request(operation.request);
  message->set_status_code(static_cast<int>(operation.code));
  message->set_status_message(operation.message);
}

}  // namespace

absl::Status ListOperations(const OperationLog& operations, absl::string_view tenant,
                            const v1::ListOperationsRequest& request,
                            v1::ListOperationsResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  const absl::StatusOr<std::int64_t> before =
      convert::NumberFromPageToken(request.page_token(), std::numeric_limits<std::int64_t>::max());
  if (!before.ok()) return before.status();
  for (const Operation& operation : operations.List(tenant, *before, *size + 1)) {
    if (response->operations_size() == *size) {
      response->set_next_page_token(std::to_string(response->operations(*size - 1).number()));
      break;
    }
    Describe(operation, response->add_operations());
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
