import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { AdminService, type Session } from "proto/dcloc/v1/admin_service_pb.ts";
import { MapService } from "proto/dcloc/v1/map_service_pb.ts";
import type { StreamEnd } from "../../shared/live.ts";
import { distanceOutside, extentOf } from "../map/extent.ts";
import { Fleet } from "../map/fleet.ts";
import { Dialog } from "../parts/dialog.tsx";
import { Link } from "../parts/link.tsx";
import { FailureNotice, Loading, Notice } from "../parts/notice.tsx";
import { go, pathOf } from "../parts/route.ts";
import { StateMark } from "../parts/state_mark.tsx";
import { useCall } from "../parts/use_call.ts";
import type { Shelf } from "../recording/shelf.ts";
import { LiveScans } from "../scan/live_scans.ts";
import { BandChart, StateChanges } from "../session/band_chart.tsx";
import { SessionCharts } from "../session/charts.tsx";
import { explain } from "../session/explain.ts";
import { History } from "../session/history.ts";
import { FIRST_PROPOSAL, type ProposalDraft, drawProposal, isPlaced } from "../session/proposal.ts";
import { ProposePose } from "../session/propose_pose.tsx";
import { SessionMap } from "../session/session_map.tsx";
import { Sources } from "../session/sources.tsx";
import { Stages } from "../session/stages.tsx";
import { Why } from "../session/why.tsx";
import { shownName } from "../texts/shortened.ts";
import { count, dateTime, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { expected } from "../wire/expected.ts";
import { CallFailure, Code } from "../wire/failure.ts";
import type { FleetLink } from "../wire/use_fleet.ts";
import { watchSession } from "../wire/watch_stream.ts";

const SHOW_MS = 200;
const RETRY_MS = 2_000;
/** So much of the states is shown. */
const BANDS_MS = 10 * 60_000;

/** Watches a session; what uses it is shown again five times a second. */
function useWatch(server: string, id: string) {
  const history = useRef(new History());
  const scans = useRef(new LiveScans());
  const [tick, setTick] = useState(0);
  const [end, setEnd] = useState<StreamEnd>();
  useEffect(() => {
    let leave: () => void = () => undefined;
    let retry: ReturnType<typeof setTimeout>;
    history.current = new History();
    scans.current = new LiveScans();
    setEnd(undefined);
    const watch = (): void => {
      leave = watchSession(server, id, {
        onAnswer: (answer) => {
          history.current.take(answer, performance.now());
          scans.current.take(answer, performance.now());
        },
        onMissed: (missed) => (history.current.missed = missed),
        onEnd: (told) => {
          if (told.code === Code.Unavailable) retry = setTimeout(watch, RETRY_MS);
          else setEnd(told);
        },
      });
    };
    watch();
    const timer = setInterval(() => setTick((n) => n + 1), SHOW_MS);
    return () => {
      leave();
      clearTimeout(retry);
      clearInterval(timer);
    };
  }, [server, id]);
  return { history: history.current, scans: scans.current, tick, end };
}

interface Props {
  server: string;
  id: string;
  fleet: FleetLink;
  shelf: Shelf;
}

/** One session: what it answers, how it got there, and what explains it. */
export function SessionView({ server, id, fleet, shelf }: Props) {
  const { history, scans, tick, end } = useWatch(server, id);
  const loaded = useCall(
    async (signal) => {
      const request = { sessionId: id };
      return expected((await call(server, AdminService.method.getSession, request, signal)).session);
    },
    [server, id],
    2_000,
  );
  const session = loaded.value;
  const mapName = session?.mapName ?? "";
  const version = Number(session?.mapVersion ?? 0n);
  const map = useCall(
    async (signal) => {
      if (!mapName) return undefined;
      const request = { mapName, version: BigInt(version) };
      return (await call(server, MapService.method.getMapVersion, request, signal)).version;
    },
    [server, mapName, version],
  );
  const extent = useMemo(() => extentOf(map.value?.info), [map.value]);
  const drawnMap = useMemo(
    () => (version > 0 ? { server, name: mapName, version } : undefined),
    [server, mapName, version],
  );
  const [isEnding, setEnding] = useState(false);
  const [isProposing, setProposing] = useState(false);
  const isPlacing = isProposing && !end;
  const [proposal, setProposal] = useState<ProposalDraft>(FIRST_PROPOSAL);
  const overlay = useMemo(
    () => (isPlacing && isPlaced(proposal) ? drawProposal(proposal) : undefined),
    [isPlacing, proposal],
  );
  if (!session) {
    if (!loaded.failure) return <Loading />;
    return <FailureNotice failure={loaded.failure} retry={loaded.reload} />;
  }
  const { last } = history;
  const nowMs = performance.now();
  const info = map.value?.info;
  const { samples, rejections, health } = history;
  const outsideM = info && last ? distanceOutside(info, last.x, last.y) : 0;
  const findings = explain({ samples, rejections, health, outsideM, nowMs });
  return (
    <div class="session">
      <section class="session-main">
        <header class="session-head">
          <div>
            <p class="crumbs">
              <Link to="/live">{t("live")}</Link> / {shownName(session.mapName)} v{version}
            </p>
            <h1>{shownName(session.vehicleId)}</h1>
          </div>
          <StateMark state={last?.state ?? session.state} />
          <button onClick={() => go(pathOf("recordings", shelf.record(server, session.vehicleId).id))}>
            {t("record_next")}
          </button>
          {!end && (
            <button aria-pressed={isProposing} onClick={() => setProposing(!isProposing)}>
              {t("propose_pose")} …
            </button>
          )}
          {!end && (
            <button class="danger" onClick={() => setEnding(true)}>
              {t("end_session")} …
            </button>
          )}
        </header>
        {end && <Ended end={end} />}
        <Why findings={findings} />
        {history.missed > 0 && <p class="hint">{t("missed", { count: count(history.missed) })}</p>}
        <BandChart
          bands={history.bands.all}
          beginMs={nowMs - BANDS_MS}
          endMs={nowMs}
          tick={tick}
        >
          <p class="band-axis soft">
            <span>{t("minutes_ago", { minutes: BANDS_MS / 60_000 })}</span>
            <span>{t("now")}</span>
          </p>
          <StateChanges segments={history.bands.states} originMs={nowMs} />
        </BandChart>
        <SessionCharts
          samples={samples}
          nowMs={nowMs}
          isSpatial={info?.hasElevation ?? false}
          tick={tick}
        />
      </section>
      <aside class="session-side">
        <SessionMap
          server={server}
          id={id}
          map={drawnMap}
          extent={extent}
          history={history}
          scans={scans}
          vehicle={fleet.fleet.vehicles.get(Fleet.key(server, id))}
          overlay={overlay}
          onPlace={isPlacing ? (x, y) => setProposal((old) => ({ ...old, x, y })) : undefined}
        />
        {isPlacing && (
          <ProposePose
            server={server}
            session={id}
            proposal={proposal}
            onChange={setProposal}
            onClose={() => setProposing(false)}
          />
        )}
        <Sources health={health ?? session.health} />
        <Stages samples={samples} />
        <Facts session={session} />
      </aside>
      {isEnding && <EndDialog server={server} session={session} onClose={() => setEnding(false)} />}
    </div>
  );
}

function Ended({ end }: { end: StreamEnd }) {
  if (end.code === 0 || end.code === Code.NotFound) {
    const text = end.message ? t("session_over_because", { message: end.message }) : t("session_over");
    return <Notice title={text} />;
  }
  return <FailureNotice failure={new CallFailure(end.code, end.message)} />;
}

function Facts({ session }: { session: Session }) {
  const n = (value: bigint): string => count(Number(value));
  const facts: [string, string][] = [
    [t("opened"), dateTime(Number(session.openTime?.seconds ?? 0n) * 1000)],
    [t("scans"), n(session.scanCount)],
    [t("rejected"), n(session.rejectedScanCount)],
    [t("dropped"), n(session.droppedScanCount)],
    [t("missing"), n(session.missingScanCount)],
    [t("resumed"), n(session.resumeCount)],
    [t("resets"), n(session.poseResetCount)],
    ...(session.replica ? [[t("server"), shownName(session.replica)] as [string, string]] : []),
    [t("peer"), shownName(session.peer)],
    [t("session"), shownName(session.sessionId)],
  ];
  return (
    <section aria-label={t("session")}>
      <h2>{t("session")}</h2>
      <dl class="facts">
        {facts.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

interface EndProps {
  server: string;
  session: Session;
  onClose: () => void;
}

function EndDialog({ server, session, onClose }: EndProps) {
  const [reason, setReason] = useState("");
  const { sessionId } = session;
  return (
    <Dialog
      title={t("end_session_title", { vehicle: shownName(session.vehicleId) })}
      action={t("end_session")}
      isDangerous
      onClose={onClose}
      onDo={() => call(server, AdminService.method.endSession, { sessionId, reason })}
    >
      <p>{t("end_session_text")}</p>
      <label>
        {t("reason")}
        <input maxLength={200} value={reason} onInput={(e) => setReason(e.currentTarget.value)} />
      </label>
    </Dialog>
  );
}
