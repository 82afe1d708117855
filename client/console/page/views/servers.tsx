import { useRef } from "preact/hooks";
import { FailureNotice, Loading } from "../parts/notice.tsx";
import { useCall } from "../parts/use_call.ts";
import { t } from "../texts/texts.ts";
import type { ServerName } from "../wire/calls.ts";
import { type FleetServer, listServers, withLastStates } from "./fleet_servers.ts";
import { Identities } from "./identities.tsx";
import { Operations } from "./operations.tsx";
import { PERIOD_MS, ServerCard } from "./server_card.tsx";

/** The servers of the fleet, what they do, and who may do and did what. */
export function ServersView({ servers }: { servers: readonly ServerName[] }) {
  const last = useRef<FleetServer[]>([]);
  const { value, failure, reload } = useCall(
    async (signal) => (last.current = withLastStates(await listServers(servers, signal), last.current)),
    [servers.length],
    PERIOD_MS,
  );
  const isFleet = (value?.length ?? 0) > servers.length;
  return (
    <div class="sheet">
      <div class="sheet-head">
        <h1>{t("servers")}</h1>
      </div>
      {failure && !value && <FailureNotice failure={failure} retry={reload} />}
      {!failure && !value && <Loading />}
      <div class="cards">
        {value?.map((server) => (
          <ServerCard key={server.name} server={server} reload={reload} />
        ))}
      </div>
      {servers.map(({ name }) => (
        <section key={name} class="sheet-part" aria-label={t("records_of", { server: name })}>
          {servers.length > 1 && <h2>{name}</h2>}
          <Operations server={name} />
          {isFleet && <p class="hint">{t("operations_of_one")}</p>}
          <Identities server={name} />
        </section>
      ))}
    </div>
  );
}
