import { useRef, useState } from "preact/hooks";
import { AdminService, type GetServerStateResponse } from "proto/dcloc/v1/admin_service_pb.ts";
import { Dialog } from "../parts/dialog.tsx";
import { FailureNotice } from "../parts/notice.tsx";
import { shortened, shownName } from "../texts/shortened.ts";
import { count, dateTime, decimals, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";
import type { FleetServer } from "./fleet_servers.ts";

/** The figures of a server are read so often. */
export const PERIOD_MS = 2_000;

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

interface Props {
  server: FleetServer;
  reload: () => void;
}

/** One server: what it does, and what can be done with it. */
export function ServerCard({ server, reload }: Props) {
  const [isDraining, setDraining] = useState(false);
  const { state, fault, failure, via, replica } = server;
  const rate = useRate(state && Number(state.scanCount));
  const isSilent = fault !== undefined || failure?.code === Code.Unavailable;
  const name = shownName(server.name);
  return (
    <article class="card" aria-label={name}>
      <header>
        <div>
          <h2>{name}</h2>
          <span class="soft">
            {name === via.name ? via.address : t("asked_through", { server: via.name })}
          </span>
        </div>
        <ServerLabel state={state} isSilent={isSilent} />
      </header>
      {failure && !state && <FailureNotice failure={failure} retry={reload} />}
      {fault !== undefined && <p class="fault">{t("replica_fault", { fault: shortened(fault) })}</p>}
      {state && <Figures state={state} rate={rate} />}
      {state && !state.draining && !isSilent && (
        <button class="danger" onClick={() => setDraining(true)}>
          {t("drain")} …
        </button>
      )}
      {isDraining && (
        <Dialog
          title={t("drain_title", { server: name })}
          action={t("drain")}
          isDangerous
          onClose={() => setDraining(false)}
          onDo={() => call(via.name, AdminService.method.drain, { replica }).then(reload)}
        >
          <p>{t("drain_text", { count: count(state?.sessionCount ?? 0) })}</p>
        </Dialog>
      )}
    </article>
  );
}

interface LabelProps {
  state: GetServerStateResponse | undefined;
  isSilent: boolean;
}

function ServerLabel({ state, isSilent }: LabelProps) {
  if (isSilent) return <span class="label fault">{t("not_reached")}</span>;
  if (!state) return null;
  if (state.draining) return <span class="label canary">{t("draining")}</span>;
  return <span class="label active">{t("serving")}</span>;
}

function figuresOf(state: GetServerStateResponse, rate: number | undefined): [string, string][] {
  const ms = (time: { seconds: bigint } | undefined): number => Number(time?.seconds ?? 0n) * 1000;
  const figures: [string, string][] = [
    [t("load"), rate === undefined ? "–" : decimals(rate, rate < 10 ? 1 : 0)],
    [t("detached_sessions"), count(state.detachedSessionCount)],
    [
      t("unopened_streams"),
      t("of_max", {
        count: count(state.unopenedStreamCount),
        max: count(state.maxUnopenedStreamCount),
      }),
    ],
    [t("loaded_maps"), count(state.loadedMapCount)],
    [t("scans"), count(Number(state.scanCount))],
    [t("rejected"), count(Number(state.rejectedScanCount))],
    [t("dropped"), count(Number(state.droppedScanCount))],
    [t("repeated"), count(Number(state.repeatedScanCount))],
    [t("resumed"), count(Number(state.resumeCount))],
    [t("workers"), count(state.workerCount)],
    [t("program_version"), shownName(state.serverVersion)],
    [t("up_since"), dateTime(ms(state.startTime))],
  ];
  if (state.certificateExpireTime) {
    figures.push([t("certificate"), dateTime(ms(state.certificateExpireTime))]);
  }
  return figures;
}

function Figures({ state, rate }: { state: GetServerStateResponse; rate: number | undefined }) {
  const ofMax = t("of_max", {
    count: count(state.sessionCount),
    max: count(state.maxSessionCount),
  });
  return (
    <>
      <label class="meter">
        {t("sessions")}: {ofMax}
        <meter
          min={0}
          max={1}
          high={0.8}
          optimum={0}
          value={state.sessionCount / Math.max(1, state.maxSessionCount)}
        />
      </label>
      {state.stubMatcher && <p class="fault">{t("stub")}</p>}
      {state.certificateFault && (
        <p class="fault">{t("certificate_fault", { fault: shortened(state.certificateFault) })}</p>
      )}
      <dl class="facts">
        {figuresOf(state, rate).map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
    </>
  );
}
