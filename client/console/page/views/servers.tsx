import { useRef, useState } from "preact/hooks";
import { AdminService, type GetServerStateResponse } from "proto/dcloc/v1/admin_service_pb.ts";
import { Dialog } from "../parts/dialog.tsx";
import { FailureNotice, Loading } from "../parts/notice.tsx";
import { useCall } from "../parts/use_call.ts";
import { count, dateTime, decimals, t } from "../texts/texts.ts";
import { type ServerName, call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";
import { Identities } from "./identities.tsx";
import { Operations } from "./operations.tsx";

const PERIOD_MS = 2_000;

export function ServersView({ servers }: { servers: readonly ServerName[] }) {
  return (
    <div class="sheet">
      <div class="sheet-head">
        <h1>{t("servers")}</h1>
      </div>
      <div class="cards">
        {servers.map((server) => (
          <ServerCard key={server.name} server={server} />
        ))}
      </div>
      {servers.map(({ name }) => (
        <section key={name} class="sheet-part" aria-label={t("records_of", { server: name })}>
          {servers.length > 1 && <h2>{name}</h2>}
          <Operations server={name} />
          <Identities server={name} />
        </section>
      ))}
    </div>
  );
}

/** Scans per second between this figure and the one before. */
function useRate(value: number | undefined): number | undefined {
  const last = useRef<{ value: number; ms: number }>();
  const rate = useRef<number>();
  const now = performance.now();
  if (value !== undefined && value !== last.current?.value) {
    const seconds = (now - (last.current?.ms ?? now)) / 1000;
    if (seconds > 0) rate.current = Math.max(0, (value - last.current!.value) / seconds);
    last.current = { value, ms: now };
  } else if (last.current && now - last.current.ms > 2 * PERIOD_MS) {
    rate.current = 0;
  }
  return rate.current;
}

function ServerCard({ server }: { server: ServerName }) {
  const [isDraining, setDraining] = useState(false);
  const { value, failure, reload } = useCall(
    (signal) => call(server.name, AdminService.method.getServerState, {}, signal),
    [server.name],
    PERIOD_MS,
  );
  const rate = useRate(value && Number(value.scanCount));
  return (
    <article class="card">
      <header>
        <div>
          <h2>{server.name}</h2>
          <span class="soft">{server.address}</span>
        </div>
        <ServerLabel state={value} isCut={failure?.code === Code.Unavailable} />
      </header>
      {failure && !value && <FailureNotice failure={failure} retry={reload} />}
      {!failure && !value && <Loading />}
      {value && <Figures state={value} rate={rate} />}
      {value && !value.draining && (
        <button class="danger" onClick={() => setDraining(true)}>
          {t("drain")} …
        </button>
      )}
      {isDraining && (
        <Dialog
          title={t("drain_title", { server: server.name })}
          action={t("drain")}
          isDangerous
          onClose={() => setDraining(false)}
          onDo={() => call(server.name, AdminService.method.drain, {}).then(reload)}
        >
          <p>{t("drain_text", { count: count(value?.sessionCount ?? 0) })}</p>
        </Dialog>
      )}
    </article>
  );
}

function ServerLabel({ state, isCut }: { state: GetServerStateResponse | undefined; isCut: boolean }) {
  if (isCut) return <span class="label fault">{t("not_reached")}</span>;
  if (!state) return null;
  if (state.draining) return <span class="label canary">{t("draining")}</span>;
  return <span class="label active">{t("serving")}</span>;
}

function Figures({ state, rate }: { state: GetServerStateResponse; rate: number | undefined }) {
  const used = state.sessionCount / Math.max(1, state.maxSessionCount);
  const ms = (time: { seconds: bigint } | undefined): number => Number(time?.seconds ?? 0n) * 1000;
  const figures: [string, string][] = [
    [t("load"), rate === undefined ? "–" : decimals(rate, rate < 10 ? 1 : 0)],
    [t("detached_sessions"), count(state.detachedSessionCount)],
    [t("loaded_maps"), count(state.loadedMapCount)],
    [t("scans"), count(Number(state.scanCount))],
    [t("rejected"), count(Number(state.rejectedScanCount))],
    [t("dropped"), count(Number(state.droppedScanCount))],
    [t("resumed"), count(Number(state.resumeCount))],
    [t("workers"), count(state.workerCount)],
    [t("program_version"), state.serverVersion],
    [t("up_since"), dateTime(ms(state.startTime))],
  ];
  if (state.certificateExpireTime) {
    figures.push([t("certificate"), dateTime(ms(state.certificateExpireTime))]);
  }
  const ofMax = t("of_max", {
    count: count(state.sessionCount),
    max: count(state.maxSessionCount),
  });
  return (
    <>
      <label class="meter">
        {t("sessions")}: {ofMax}
        <meter min={0} max={1} high={0.8} optimum={0} value={used} />
      </label>
      {state.stubMatcher && <p class="fault">{t("stub")}</p>}
      {state.certificateFault && (
        <p class="fault">{t("certificate_fault", { fault: state.certificateFault })}</p>
      )}
      <dl class="facts">
        {figures.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
    </>
  );
}
