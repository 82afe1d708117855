#include "server/maps/service/pass_service.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/convert/page.h"
#include "server/convert/time.h"
#include "server/rpc/unary.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

absl::StatusOr<ConsentRow> ConsentFromProto(const v1::PassConsent& message) {
  if (message.subject_case() == v1::PassConsent::SUBJECT_NOT_SET) {
    return Missing("consent.subject");
  }
  const bool of_map = message.has_map_name();
  const ConsentRow row{.subject = of_map ? ConsentSubject::kMap : ConsentSubject::kIdentity,
                       .name = of_map ? message.map_name() : message.identity_name()};
  absl::Status status = of_map ? CheckMapName("consent.map_name", row.name)
                               : CheckId("consent.identity_name", row.name);
  if (!status.ok()) return status;
  return row;
}

void ToProto(const ConsentRow& row, v1::PassConsent* message) {
  if (row.subject == ConsentSubject::kMap) {
    message->set_map_name(row.name);
  } else {
    message->set_identity_name(row.name);
  }
}

void ToProto(const PassRow& row, v1::Pass* message) {
  message->set_pass_id(row.pass_id);
  message->set_map_name(row.map_name);
  message->set_map_version(row.map_version);
  message->set_vehicle_pseudonym(row.vehicle);
  message->set_scan_count(row.scan_count);
  message->set_size_bytes(row.size_bytes);
  message->set_first_stamp_ns(row.first_stamp_ns);
  message->set_last_stamp_ns(row.last_stamp_ns);
  *message->mutable_create_time() = convert::ToProto(row.create_time);
  *message->mutable_expire_time() = convert::ToProto(row.expire_time);
}

absl::Status SetConsent(PassStore& passes, const std::string& tenant,
                        const v1::SetPassConsentRequest& request,
                        v1::SetPassConsentResponse* response) {
  const absl::StatusOr<ConsentRow> consent = ConsentFromProto(request.consent());
  if (!consent.ok()) return consent.status();
  if (request.state() == v1::PASS_CONSENT_STATE_GIVEN) {
    absl::Status status = passes.GiveConsent(tenant, *consent);
    if (status.ok()) spdlog::info("pass consent given tenant={} name={}", tenant, consent->name);
    return status;
  }
  if (request.state() != v1::PASS_CONSENT_STATE_WITHDRAWN) {
    return absl::InvalidArgumentError(
        absl::StrFormat("state is %d; it must be GIVEN or WITHDRAWN", request.state()));
  }
  const absl::StatusOr<int> count = passes.WithdrawConsent(tenant, *consent);
  if (!count.ok()) return count.status();
  response->set_removed_pass_count(*count);
  spdlog::info("pass consent withdrawn tenant={} name={} removed={}", tenant, consent->name,
               *count);
  return absl::OkStatus();
}

absl::Status ListConsents(PassRows& rows, const std::string& tenant,
                          const v1::ListPassConsentsRequest& request,
                          v1::ListPassConsentsResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  const absl::StatusOr<std::int64_t> offset = convert::NumberFromPageToken(request.page_token(), 0);
  if (!offset.ok()) return offset.status();
  // One more than a page holds tells whether another one follows.
  const auto consents = rows.ListConsents(tenant, *offset, *size + 1);
  if (!consents.ok()) return consents.status();
  for (const ConsentRow& consent : *consents) {
    if (response->consents_size() == *size) {
      response->set_next_page_token(std::to_string(*offset + *size));
      break;
    }
    ToProto(consent, response->add_consents());
  }
  return absl::OkStatus();
}

absl::Status ListPassPage(PassRows& rows, const std::string& tenant,
                          const v1::ListPassesRequest& request, v1::ListPassesResponse* response) {
  absl::Status status = CheckMapName("map_name", request.map_name());
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  const absl::StatusOr<std::int64_t> below =
      convert::NumberFromPageToken(request.page_token(), std::numeric_limits<std::int64_t>::max());
  status.Update(size.status());
  status.Update(below.status());
  if (!status.ok()) return status;
  const auto passes = rows.List(tenant, request.map_name(), *below, *size + 1);
  if (!passes.ok()) return passes.status();
  for (int i = 0; i < static_cast<int>(passes->size()); ++i) {
    if (i == *size) {
      response->set_next_page_token(
          std::to_string((*passes)[static_cast<std::size_t>(i - 1)].number));
      break;
    }
    ToProto((*passes)[static_cast<std::size_t>(i)], response->add_passes());
  }
  return absl::OkStatus();
}

}  // namespace

PassService::PassService(RpcContext host, PassStore& passes) : host_(host), passes_(passes) {
  AwaitRequests(host.awaited_requests, &PassService::SetPassConsent, &PassService::ListPassConsents,
                &PassService::ListPasses);
}

grpc::ServerUnaryReactor* PassService::SetPassConsent(grpc::CallbackServerContext* context,
                                                      const v1::SetPassConsentRequest* request,
                                                      v1::SetPassConsentResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return SetConsent(passes_, principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* PassService::ListPassConsents(grpc::CallbackServerContext* context,
                                                        const v1::ListPassConsentsRequest* request,
                                                        v1::ListPassConsentsResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return ListConsents(passes_.rows(), principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* PassService::ListPasses(grpc::CallbackServerContext* context,
                                                  const v1::ListPassesRequest* request,
                                                  v1::ListPassesResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return ListPassPage(passes_.rows(), principal.tenant, *request, response);
  });
}

}  // namespace dcloc::server
