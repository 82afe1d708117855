import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { around, distanceOutside, extentOf } from "../map/extent.ts";
import { Fleet } from "../map/fleet.ts";
import { MapCanvas } from "../map/map_canvas.tsx";
import { FailureNotice, Loading, Notice } from "../parts/notice.tsx";
import { Link } from "../parts/link.tsx";
import { StateMark } from "../parts/state_mark.tsx";
import { useCall } from "../parts/use_call.ts";
import { type FoundMap, findMap } from "../recording/find_map.ts";
import { Player } from "../recording/player.ts";
import type { Recording } from "../recording/recording.ts";
import { ReplayScene } from "../recording/replay_scene.ts";
import type { Item, Shelf } from "../recording/shelf.ts";
import { Transport, keyAction } from "../recording/transport.tsx";
import { drawTargets } from "../scan/draw_scan.ts";
import { ScanLegend } from "../scan/scan_legend.tsx";
import { useSurroundings } from "../scan/use_surroundings.ts";
import { BandChart, StateChanges } from "../session/band_chart.tsx";
import { SessionCharts } from "../session/charts.tsx";
import { explain } from "../session/explain.ts";
import { Sources } from "../session/sources.tsx";
import { Why } from "../session/why.tsx";
import { shortened } from "../texts/shortened.ts";
import { count, currentLanguage, numbered, t } from "../texts/texts.ts";
import type { ServerName } from "../wire/calls.ts";
import { itemText, refusalText, useShelf } from "./recordings.tsx";

/** Half of the square that is shown around the vehicle at first. */
const FIRST_VIEW_M = 60;
const CHARTS_MS = 60_000;
/** Figures beside the map change so often. */
const FIGURES_MS = 200;
const SERVER_UNKNOWN = "-";

interface Props {
  shelf: Shelf;
  id: string;
  servers: readonly ServerName[];
}

/** A recording, played, or watched while it is made; else what hinders that. */
export function ReplayView({ shelf, id, servers }: Props) {
  useShelf(shelf);
  const item = shelf.find(id);
  if (!item) {
    return (
      <Notice title={t("recording_gone_title")}>
        <p>{t("recording_gone_text")}</p>
        <Link to="/recordings">{t("recordings")}</Link>
      </Notice>
    );
  }
  const { recorder, recording } = item;
  if (item.refusal) {
    return (
      <Notice title={item.name} kind="alarm">
        <p>{refusalText(item.refusal)}</p>
        <Link to="/recordings">{t("recordings")}</Link>
      </Notice>
    );
  }
  if (item.readShare !== undefined || !recording.header) {
    if (recorder?.failure) return <FailureNotice failure={recorder.failure} />;
    return (
      <Notice title={item.name}>
        <p>{itemText(item)}</p>
        {recorder?.state === "waiting" && <p class="hint">{t("record_text")}</p>}
        <Link to="/recordings">{t("recordings")}</Link>
      </Notice>
    );
  }
  return <Replay key={id} item={item} shelf={shelf} servers={servers} />;
}

/** Lets time pass while the recording is played; its user is shown again with each frame. */
function usePlayer(recording: Recording): { player: Player; show: () => void } {
  const player = useRef(new Player(recording.ending === undefined));
  const [, setFrame] = useState(0);
  const show = (): void => setFrame((n) => n + 1);
  useEffect(() => {
    let before = performance.now();
    let request = 0;
    const pass = (now: number): void => {
      const { current } = player;
      const { positionMs } = current;
      current.advance(now - before, recording.durationMs);
      before = now;
      if (current.positionMs !== positionMs) show();
      request = requestAnimationFrame(pass);
    };
    request = requestAnimationFrame(pass);
    return () => cancelAnimationFrame(request);
  }, [recording]);
  return { player: player.current, show };
}

/** Keys work wherever the focus is. */
function useKeys(onKey: (event: KeyboardEvent) => void): void {
  const latest = useRef(onKey);
  latest.current = onKey;
  useEffect(() => {
    const listener = (event: KeyboardEvent): void => latest.current(event);
    addEventListener("keydown", listener);
    return () => removeEventListener("keydown", listener);
  }, []);
}

function Replay({ item, shelf, servers }: Omit<Props, "id"> & { item: Item }) {
  const { recording, recorder } = item;
  const header = recording.header!;
  const { player, show } = usePlayer(recording);
  const found = useCall((signal) => findMap(servers, recorder?.server, header, signal), [header]);
  const map = useMemo(
    () =>
      found.value && {
        server: found.value.server,
        name: found.value.version.mapName,
        version: Number(found.value.version.version),
      },
    [found.value],
  );
  const surroundings = useSurroundings(map, show);
  const scene = useMemo(() => new ReplayScene(recording), [recording]);
  const [follow, setFollow] = useState(true);
  const { positionMs } = player;
  const { samples } = recording;
  const here = recording.samplesIn(positionMs - CHARTS_MS, positionMs);
  const last = here[here.length - 1] ?? (positionMs === 0 ? samples[0] : undefined);
  const first = samples[0];
  const firstView = useMemo(() => first && around(first.x, first.y, FIRST_VIEW_M), [first]);
  const info = found.value?.version.info;
  const extent = useMemo(() => extentOf(info) ?? firstView, [info, firstView]);
  const server = found.value?.server ?? SERVER_UNKNOWN;
  if (last) surroundings?.moveTo(last.x, last.y);
  const act = (change: () => void): void => {
    change();
    show();
  };
  useKeys((event) => keyAction(event, player, recording, act));
  const seek = (timeMs: number): void => act(() => player.seek(timeMs, recording.durationMs));
  const figures = Math.floor(positionMs / FIGURES_MS);
  const tick = figures + recording.samples.length;
  return (
    <div class="session replay">
      <section class="session-main">
        <header class="session-head">
          <div>
            <p class="crumbs">
              <Link to="/recordings">{t("recordings")}</Link> / {shortened(header.opened?.mapName ?? "")} v
              {String(header.opened?.mapVersion ?? 0n)}
            </p>
            <h1>{shortened(header.open?.vehicleId || item.name)}</h1>
          </div>
          {last && <StateMark state={last.state} />}
          {recorder && recorder.state !== "ended" && (
            <button onClick={() => recorder.stop()}>{t("stop")}</button>
          )}
          <button onClick={() => shelf.save(item)}>{t("download")}</button>
        </header>
        <Faults item={item} map={found.value} isSought={!found.value && !found.failure} />
        <div class="replay-map">
          {first ? (
            <MapCanvas
              map={map}
              extent={extent}
              firstView={firstView}
              overlay={(context, camera, palette) =>
                drawTargets(context, camera, palette, scene.targetsAt(positionMs, surroundings))
              }
              vehicles={() => (last ? [scene.vehicleAt(last, server)] : [])}
              chosen={Fleet.key(server, "replay")}
              follow={follow}
              tick={positionMs}
            />
          ) : (
            <Loading />
          )}
          <label class="chip">
            <input type="checkbox" checked={follow} onChange={(e) => setFollow(e.currentTarget.checked)} />
            {t("follow")}
          </label>
        </div>
        <ScanLegend />
        <Transport player={player} recording={recording} act={act} />
        <BandChart
          bands={recording.bands.all}
          beginMs={0}
          endMs={recording.durationMs}
          positionMs={positionMs}
          onSeek={seek}
          tick={tick}
        >
          <StateChanges segments={recording.bands.states} originMs={0} onSeek={seek} />
        </BandChart>
        <Figures recording={recording} positionMs={positionMs} tick={tick} map={found.value} />
      </section>
      <aside class="session-side">
        <RecordedSources recording={recording} positionMs={positionMs} tick={figures} />
        <RecordedFacts recording={recording} />
      </aside>
    </div>
  );
}

/** What a reader of the recording has to know before trusting it. */
function Faults({ item, map, isSought }: { item: Item; map: FoundMap | undefined; isSought: boolean }) {
  const { recording, recorder } = item;
  const fault = recording.ending?.fault?.split(" ");
  return (
    <>
      {fault && (
        <p class="fault" role="alert">
          {numbered(`file_${fault[0]}_`, 0, "") ||
            t("file_incomplete", { at: count(Number(fault[1])), scans: count(recording.scanCount) })}
        </p>
      )}
      {recorder && (recorder.failure || recorder.isFull) && (
        <p class="fault" role="alert">
          {itemText(item)}
        </p>
      )}
      {!map && !isSought && <p class="hint">{t("recording_map_unknown")}</p>}
      {map && !map.isCertain && <p class="hint">{t("recording_map_uncertain")}</p>}
    </>
  );
}

interface FiguresProps {
  recording: Recording;
  positionMs: number;
  tick: number;
  map: FoundMap | undefined;
}

/** What the data says at this place, and the minute before it. */
function Figures({ recording, positionMs, tick, map }: FiguresProps) {
  const info = map?.version.info;
  const rig = recording.header?.open?.rig;
  const isSpatial = (info?.hasElevation ?? false) && (rig?.radars.some((r) => r.hasElevation) ?? false);
  const content = useMemo(() => {
    const samples = recording.samplesIn(positionMs - CHARTS_MS, positionMs);
    const last = samples[samples.length - 1];
    const findings = explain({
      samples,
      rejections: recording.rejections.filter(({ timeMs }) => timeMs <= positionMs),
      health: recording.healthAt(positionMs),
      outsideM: info && last ? distanceOutside(info, last.x, last.y) : 0,
      nowMs: positionMs,
    });
    return { samples, findings };
  }, [recording, tick, info, currentLanguage()]);
  return (
    <>
      <Why findings={content.findings} />
      <SessionCharts samples={content.samples} nowMs={positionMs} isSpatial={isSpatial} tick={tick} />
    </>
  );
}

function RecordedSources({ recording, positionMs, tick }: Omit<FiguresProps, "map">) {
  const health = useMemo(() => recording.healthAt(positionMs), [recording, tick]);
  return <Sources health={health} />;
}

function RecordedFacts({ recording }: { recording: Recording }) {
  const { header, fixUses, fixCount } = recording;
  const facts: [string, string][] = [
    [t("scans"), count(recording.scanCount)],
    [t("rejected"), count(recording.rejections.length)],
    [t("position_fixes"), count(fixCount)],
    ...[...fixUses].map(([use, times]): [string, string] => [
      numbered("fix_use_", use, t("unknown_value", { value: use })),
      count(times),
    ]),
    [t("radars"), count(header?.open?.rig?.radars.length ?? 0)],
    [t("program_version"), shortened(header?.program ?? "")],
    [t("session"), shortened(header?.opened?.sessionId ?? "")],
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
