import { AdminService } from "proto/dcloc/v1/admin_service_pb.ts";
import { shownName } from "../texts/shortened.ts";
import { t } from "../texts/texts.ts";
import { type ServerName, call } from "../wire/calls.ts";
import { currentTenant, enterTenant } from "../wire/tenant.ts";
import { useCall } from "./use_call.ts";

const PAGE_SIZE = 1_000;
const MAX_PAGE_COUNT = 20;

/** The tenants of a server's identities; none for who may not see those. */
async function tenantsOf(server: string, signal: AbortSignal): Promise<string[]> {
  const tenants = new Set<string>();
  let pageToken = "";
  for (let page = 0; page < MAX_PAGE_COUNT; ++page) {
    const request = { pageSize: PAGE_SIZE, pageToken };
    const answer = await call(server, AdminService.method.listIdentities, request, signal);
    for (const { tenant } of answer.identities) tenants.add(tenant);
    pageToken = answer.nextPageToken;
    if (pageToken === "") break;
  }
  return [...tenants];
}

interface Props {
  servers: readonly ServerName[];
  onEnter: () => void;
}

/** Whose vehicles and maps are shown, for who may see several tenants'. */
export function TenantSelect({ servers, onEnter }: Props) {
  const { value = [] } = useCall(
    async (signal) => {
      const lists = await Promise.allSettled(servers.map(({ name }) => tenantsOf(name, signal)));
      return lists.flatMap((list) => (list.status === "fulfilled" ? list.value : []));
    },
    [servers.length],
  );
  // The one that is shown can be left, whatever has become of the right to see it.
  const tenants = [...new Set(["", currentTenant(), ...value])].sort();
  if (tenants.length < 2) return null;
  return (
    <select
      class="quiet"
      aria-label={t("tenant")}
      value={currentTenant()}
      onChange={(event) => {
        enterTenant(event.currentTarget.value);
        onEnter();
      }}
    >
      {tenants.map((tenant) => (
        <option key={tenant} value={tenant}>
          {tenant === "" ? t("default_tenant") : shownName(tenant)}
        </option>
      ))}
    </select>
  );
}
