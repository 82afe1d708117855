import { useState } from "preact/hooks";
import { type Map as RadarMap, MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { DataTable } from "../parts/data_table.tsx";
import { Link } from "../parts/link.tsx";
import { FailureNotice, Loading, Notice } from "../parts/notice.tsx";
import { pathOf } from "../parts/route.ts";
import { useCall } from "../parts/use_call.ts";
import { shownName } from "../texts/shortened.ts";
import { count, dateTime, decimals, t } from "../texts/texts.ts";
import { type ServerName, call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";
import type { FleetLink } from "../wire/use_fleet.ts";
import { Builds } from "./builds.tsx";
import { UploadDialog } from "./upload.tsx";

const MAX_PAGE_COUNT = 20;

/** All maps of a server, page by page. */
async function listMaps(server: string, signal: AbortSignal): Promise<RadarMap[]> {
  const maps: RadarMap[] = [];
  let pageToken = "";
  for (let page = 0; page < MAX_PAGE_COUNT; ++page) {
    const request = { pageSize: 1000, pageToken };
    const answer = await call(server, MapService.method.listMaps, request, signal);
    maps.push(...answer.maps);
    pageToken = answer.nextPageToken;
    if (pageToken === "") break;
  }
  return maps;
}

export function MapsView({ servers, fleet }: { servers: readonly ServerName[]; fleet: FleetLink }) {
  const [isUploading, setUploading] = useState(false);
  const [round, setRound] = useState(0);
  return (
    <div class="sheet">
      <div class="sheet-head">
        <h1>{t("maps")}</h1>
        <button class="primary" onClick={() => setUploading(true)}>
          {t("upload")}
        </button>
      </div>
      {servers.map((server) => (
        <section key={server.name}>
          {servers.length > 1 && <h2>{server.name}</h2>}
          <MapsOfServer server={server.name} fleet={fleet} round={round} />
          <Builds server={server.name} />
        </section>
      ))}
      {isUploading && (
        <UploadDialog
          servers={servers}
          onClose={() => setUploading(false)}
          onDone={() => setRound((n) => n + 1)}
        />
      )}
    </div>
  );
}

function MapsOfServer({ server, fleet, round }: { server: string; fleet: FleetLink; round: number }) {
  const { value: maps, failure, reload } = useCall((s) => listMaps(server, s), [server, round], 10_000);
  if (failure && (!maps || failure.code === Code.PermissionDenied)) {
    return <FailureNotice failure={failure} retry={reload} />;
  }
  if (!maps) return <Loading />;
  if (maps.length === 0) {
    return (
      <Notice title={t("no_maps_title")}>
        <p>{t("no_maps_text")}</p>
      </Notice>
    );
  }
  const inUse = new Map<string, number>();
  for (const vehicle of fleet.fleet.vehicles.values()) {
    if (vehicle.server === server) inUse.set(vehicle.map, (inUse.get(vehicle.map) ?? 0) + 1);
  }
  return (
    <DataTable
      label={t("maps")}
      columns={[
        { name: t("map") },
        { name: t("active") },
        { name: t("versions"), kind: "number" },
        { name: t("sessions"), kind: "number" },
        { name: t("created") },
      ]}
      rows={maps.map((map) => ({
        key: map.name,
        cells: [
          <Link to={pathOf("maps", server, map.name)}>{shownName(map.name)}</Link>,
          <MapLabels map={map} />,
          count(map.versionCount),
          count(inUse.get(map.name) ?? 0),
          dateTime(Number(map.createTime?.seconds ?? 0n) * 1000),
        ],
      }))}
    />
  );
}

function MapLabels({ map }: { map: RadarMap }) {
  return (
    <>
      {map.activeVersion > 0n ? (
        <span class="label active">{t("version_n", { version: String(map.activeVersion) })}</span>
      ) : (
        <span class="soft">{t("none_active")}</span>
      )}{" "}
      {map.canaryVersion > 0n && (
        <span class="label canary">
          {t("version_n", { version: String(map.canaryVersion) })} ·{" "}
          {t("canary_share", { percent: decimals(100 * map.canaryShare, 0) })}
        </span>
      )}
    </>
  );
}
