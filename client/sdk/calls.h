#pragma once

#include <grpcpp/client_context.h>

#include <chrono>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/status.h"
#include "google/protobuf/repeated_field.h"

namespace dcloc::client {

/// Calls a unary method of a service's stub.
template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> Call(Stub& stub,
                              grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                           Response*),
                              const Request& request, std::chrono::milliseconds timeout) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  Response response;
  const grpc::Status status = (stub.*method)(&context, request, &response);
  if (!status.ok()) return FromGrpc(status);
  return response;
}

/// Calls a paged method until the last page; `items` takes a page's items out of a response.
template <typename Item, typename Stub, typename Request, typename Response>
absl::StatusOr<std::vector<Item>> CallForAllPages(
    Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
    Request request, google::protobuf::RepeatedPtrField<Item>* (Response::*items)(),
    std::chrono::milliseconds timeout) {
  std::vector<Item> all;
  do {
    absl::StatusOr<Response> page = Call(stub, method, request, timeout);
    if (!page.ok()) return page.status();
    for (Item& item : *((*page).*items)()) all.push_back(std::move(item));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return all;
}

}  // namespace dcloc::client
