import { useMemo, useState } from "preact/hooks";
import {
  type Map as RadarMap,
  MapService,
  type MapVersion,
} from "proto/dcloc/v1/map_service_pb.ts";
import { ACCURACY_GRADES } from "../map/accuracy_grade.ts";
import type { MapDrawn } from "../map/draw_map.ts";
import { extentOf } from "../map/extent.ts";
import type { Vehicle } from "../map/fleet.ts";
import { MapCanvas } from "../map/map_canvas.tsx";
import { Link } from "../parts/link.tsx";
import { FailureNotice, Loading } from "../parts/notice.tsx";
import { go } from "../parts/route.ts";
import { useCall } from "../parts/use_call.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { count, dateTime, decimals, kilometres, megabytes, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { expected } from "../wire/expected.ts";
import { inTenant } from "../wire/tenant.ts";
import type { FleetLink } from "../wire/use_fleet.ts";
import { Builds } from "./builds.tsx";
import { comparePath } from "./compare.tsx";
import { type MapAction, MapActionDialog } from "./map_actions.tsx";
import { UploadDialog } from "./upload.tsx";

interface Contents {
  map: RadarMap;
  versions: MapVersion[];
}

async function readMap(server: string, mapName: string, signal: AbortSignal): Promise<Contents> {
  const [{ map }, { versions }] = await Promise.all([
    call(server, MapService.method.getMap, { mapName }, signal),
    call(server, MapService.method.listMapVersions, { mapName, pageSize: 1000 }, signal),
  ]);
  return { map: expected(map), versions };
}

/** One map: its versions, what can be done with them, and its landmarks. */
export function MapView({ server, name, fleet }: { server: string; name: string; fleet: FleetLink }) {
  const loaded = useCall((signal) => readMap(server, name, signal), [server, name], 10_000);
  const [chosen, setChosen] = useState<number>();
  const [action, setAction] = useState<MapAction>();
  const [isUploading, setUploading] = useState(false);
  const [buildRound, setBuildRound] = useState(0);
  const [landmarks, setLandmarks] = useState<MapDrawn>({ shown: 0, count: 0, isGraded: false });
  const contents = loaded.value;
  const versions = contents?.versions ?? [];
  const wanted = chosen ?? (Number(contents?.map.activeVersion ?? 0n) || Number(versions[0]?.version));
  const version = versions.find((v) => Number(v.version) === wanted) ?? versions[0];
  const extent = useMemo(() => extentOf(version?.info), [version?.sha256]);
  const vehicles = [...fleet.fleet.vehicles.values()].filter(
    (v) => v.server === server && v.map === name,
  );
  if (!contents) {
    return loaded.failure ? (
      <FailureNotice failure={loaded.failure} retry={loaded.reload} />
    ) : (
      <Loading />
    );
  }
  const onDone = (): void => {
    if (action?.kind === "delete_map") return go("/maps");
    if (action?.kind === "delete") setChosen(undefined);
    if (action?.kind === "update") setBuildRound((n) => n + 1);
    loaded.reload();
  };
  const onDrawn = (now: MapDrawn): void =>
    setLandmarks((old) =>
      old.shown === now.shown && old.count === now.count && old.isGraded === now.isGraded ? old : now,
    );
  return (
    <div class="split">
      <section class="side wide" aria-label={t("versions")}>
        <div class="side-head">
          <p class="crumbs">
            <Link to="/maps">{t("maps")}</Link> / {server}
          </p>
          <h1>{shownName(name)}</h1>
          <MapButtons contents={contents} onAction={setAction} onUpload={() => setUploading(true)} />
        </div>
        <ul class="rows">
          {versions.map((v) => (
            <VersionRow
              key={String(v.version)}
              map={contents.map}
              version={v}
              server={server}
              isChosen={v === version}
              vehicles={vehicles}
              onChoose={() => setChosen(Number(v.version))}
              onAction={setAction}
            />
          ))}
        </ul>
        <Builds server={server} map={name} round={buildRound} />
      </section>
      <div class="stage">
        <MapCanvas
          map={version && { server, name, version: Number(version.version) }}
          extent={extent}
          vehicles={() => []}
          onDrawn={onDrawn}
        />
        <div class="legend">
          {(landmarks.isGraded ? ACCURACY_GRADES : ["unknown" as const]).map((grade) => (
            <span key={grade}>
              <span class={`swatch street-${grade}`} aria-hidden="true" /> {t(`legend_street_${grade}`)}
            </span>
          ))}
          <span>
            <span class="swatch landmark" aria-hidden="true" /> {t("legend_landmarks")}
          </span>
          <span class="soft">
            {t("points_shown", { shown: count(landmarks.shown), count: count(landmarks.count) })}
          </span>
        </div>
      </div>
      {action && (
        <MapActionDialog
          server={server}
          map={contents.map}
          action={action}
          onClose={() => setAction(undefined)}
          onDone={onDone}
        />
      )}
      {isUploading && (
        <UploadDialog
          servers={[{ name: server, address: "" }]}
          map={name}
          onClose={() => setUploading(false)}
          onDone={loaded.reload}
        />
      )}
    </div>
  );
}

interface ButtonsProps {
  contents: Contents;
  onAction: (action: MapAction) => void;
  onUpload: () => void;
}

function MapButtons({ contents: { map, versions }, onAction, onUpload }: ButtonsProps) {
  return (
    <div class="button-row">
      <button onClick={onUpload}>{t("upload")}</button>
      {map.previousVersion > 0n && (
        <button onClick={() => onAction({ kind: "roll_back", version: Number(map.previousVersion) })}>
          {t("roll_back")}
        </button>
      )}
      {map.canaryVersion > 0n && (
        <button onClick={() => onAction({ kind: "end_canary", version: Number(map.canaryVersion) })}>
          {t("end_canary")}
        </button>
      )}
      <button class="danger" onClick={() => onAction({ kind: "delete_map", version: versions.length })}>
        {t("delete_map")}
      </button>
    </div>
  );
}

interface RowProps {
  map: RadarMap;
  version: MapVersion;
  server: string;
  isChosen: boolean;
  vehicles: readonly Vehicle[];
  onChoose: () => void;
  onAction: (action: MapAction) => void;
}

function VersionRow({ map, version, server, isChosen, vehicles, onChoose, onAction }: RowProps) {
  const number = Number(version.version);
  const active = Number(map.activeVersion);
  // With the one that vehicles get; that one with the one before it.
  const other = number === active ? Number(map.previousVersion) : active;
  const inUse = vehicles.filter((v) => v.version === number).length;
  const query = new URLSearchParams({ map: map.name, version: String(number) });
  const address = inTenant(`/download/${server}?${query}`);
  return (
    <li class={isChosen ? "row chosen" : "row"}>
      <button class="row-main" aria-pressed={isChosen} onClick={onChoose}>
        <span class="row-text">
          <strong>
            {t("version_n", { version: number })} <VersionLabels map={map} version={version.version} />
          </strong>
          <span class="soft">
            {dateTime(Number(version.createTime?.seconds ?? 0n) * 1000)} ·{" "}
            {kilometres(version.info?.lengthM ?? 0)} · {t("sessions")}: {count(inUse)}
          </span>
        </span>
      </button>
      {isChosen && (
        <>
          <VersionFacts version={version} />
          <div class="row-actions">
            {version.version !== map.activeVersion && (
              <>
                <button class="primary" onClick={() => onAction({ kind: "activate", version: number })}>
                  {t("activate")}
                </button>
                <button onClick={() => onAction({ kind: "canary", version: number })}>
                  {t("set_canary")}
                </button>
              </>
            )}
            <button onClick={() => onAction({ kind: "update", version: number })}>
              {t("update")} …
            </button>
            {other > 0 && (
              <Link class="button" to={comparePath({ server, map: map.name, from: other, to: number })}>
                {t("compare_with", { version: other })}
              </Link>
            )}
            <a class="button" href={address} download>
              {t("download")}
            </a>
            <button class="danger" onClick={() => onAction({ kind: "delete", version: number })}>
              {t("delete")}
            </button>
          </div>
        </>
      )}
    </li>
  );
}

function VersionLabels({ map, version }: { map: RadarMap; version: bigint }) {
  return (
    <>
      {version === map.activeVersion && <span class="label active">{t("active")}</span>}
      {version === map.canaryVersion && (
        <span class="label canary">
          {t("canary_share", { percent: decimals(100 * map.canaryShare, 0) })}
        </span>
      )}
      {version === map.previousVersion && <span class="label">{t("previous")}</span>}
    </>
  );
}

function VersionFacts({ version }: { version: MapVersion }) {
  const { info } = version;
  const facts: [string, string][] = [
    [t("landmarks"), count(Number(info?.pointCount ?? 0n))],
    [t("keyframes"), count(Number(info?.keyframeCount ?? 0n))],
    [t("street"), kilometres(info?.lengthM ?? 0)],
    [t("size"), megabytes(Number(version.sizeBytes))],
    [t("drive"), shortened(info?.driveName ?? "")],
    ["SHA-256", `${version.sha256.slice(0, 16)}…`],
  ];
  return (
    <>
      <dl class="facts">
        {facts.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      {info?.description && <p class="facts-note soft">{shortened(info.description, 1000)}</p>}
    </>
  );
}
