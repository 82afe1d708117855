import { useState } from "preact/hooks";
import { AdminService, type Session } from "proto/dcloc/v1/admin_service_pb.ts";
import { MapBuildMethod, type Map as RadarMap, MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { Dialog } from "../parts/dialog.tsx";
import { useCall } from "../parts/use_call.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { count, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";

/** Something to be done with a map; the version that it is about. */
export interface MapAction {
  kind: "activate" | "roll_back" | "canary" | "end_canary" | "update" | "delete" | "delete_map";
  version: number;
}

interface Props {
  server: string;
  map: RadarMap;
  action: MapAction;
  onClose: () => void;
  onDone: () => void;
}

const MAX_PAGE_COUNT = 20;

/** Sessions, and the servers of the fleet whose sessions are missing among them. */
interface Found {
  sessions: Session[];
  silent: Set<string>;
}

/** The sessions in a map as the server lists them now, not as the page remembers them. */
async function sessionsIn(server: string, mapName: string, signal: AbortSignal): Promise<Found> {
  const sessions: Session[] = [];
  const silent = new Set<string>();
  let pageToken = "";
  for (let page = 0; page < MAX_PAGE_COUNT; ++page) {
    const request = { pageSize: 1000, pageToken };
    const answer = await call(server, AdminService.method.listSessions, request, signal);
    sessions.push(...answer.sessions.filter((session) => session.mapName === mapName));
    for (const { address } of answer.unanswered) silent.add(address);
    pageToken = answer.nextPageToken;
    if (pageToken === "") break;
  }
  return { sessions, silent };
}

/** Asks once, says what it will do to how many sessions, and does it. */
export function MapActionDialog({ server, map, action, onClose, onDone }: Props) {
  const [alsoSessions, setAlsoSessions] = useState(false);
  const [percent, setPercent] = useState(10);
  const found = useCall((signal) => sessionsIn(server, map.name, signal), [server, map.name]);
  const { kind, version } = action;
  const sessions = found.value?.sessions ?? [];
  const silent = [...(found.value?.silent ?? [])].map(shownName).join(", ");
  const all = sessions.length;
  const ofVersion = sessions.filter((s) => Number(s.mapVersion) === version).length;
  const words = wordsOf(map, action, { all, ofVersion, percent, alsoSessions });
  const onDo = () => perform(server, map, action, { alsoSessions, share: percent / 100 }).then(onDone);
  return (
    <Dialog
      title={words.title}
      action={words.button}
      isDangerous={kind === "delete" || kind === "delete_map"}
      isReady={found.value !== undefined || found.failure !== undefined}
      onClose={onClose}
      onDo={onDo}
    >
      {found.failure ? (
        <p class="fault">{t("sessions_unknown", { message: shortened(found.failure.message) })}</p>
      ) : found.value ? (
        words.texts.map((text) => <p key={text}>{text}</p>)
      ) : (
        <p>{t("loading")}</p>
      )}
      {silent !== "" && <p class="fault">{t("sessions_not_counted", { servers: silent })}</p>}
      {kind === "canary" && (
        <label>
          {t("share_percent")}
          <input
            type="number"
            min={1}
            max={100}
            required
            value={percent}
            onInput={(event) => setPercent(event.currentTarget.valueAsNumber)}
          />
        </label>
      )}
      {words.choice && (
        <label class="choice">
          <input
            type="checkbox"
            checked={alsoSessions}
            onChange={(event) => setAlsoSessions(event.currentTarget.checked)}
          />
          {words.choice}
        </label>
      )}
    </Dialog>
  );
}

interface Effect {
  all: number;
  ofVersion: number;
  percent: number;
  alsoSessions: boolean;
}

interface Words {
  title: string;
  button: string;
  texts: string[];
  choice?: string;
}

function wordsOf(map: RadarMap, { kind, version }: MapAction, effect: Effect): Words {
  const values = {
    map: map.name,
    version,
    versions: map.versionCount,
    from: map.activeVersion > 0n ? `v${map.activeVersion}` : t("none_active"),
    percent: effect.percent,
    count: count(kind === "delete" || kind === "end_canary" ? effect.ofVersion : effect.all),
  };
  const { alsoSessions } = effect;
  switch (kind) {
    case "activate":
    case "roll_back":
      return {
        title: t(kind === "activate" ? "activate_title" : "roll_back_title", values),
        button: t(kind),
        texts: [
          t("activate_text", values),
          alsoSessions ? t("activate_moves", values) : t("activate_keeps"),
        ],
        choice: t("move_sessions"),
      };
    case "canary":
      return { title: t("canary_title", values), button: t("canary"), texts: [t("canary_text", values)] };
    case "end_canary":
      return {
        title: t("end_canary_title", values),
        button: t("end_canary"),
        texts: [t("end_canary_text", values)],
      };
    case "update":
      return {
        title: t("update_title", values),
        button: t("update"),
        texts: [t("update_text"), t("update_keeps")],
      };
    case "delete":
    case "delete_map": {
      const isMap = kind === "delete_map";
      const drained = isMap ? t("delete_ends") : t("delete_drains");
      return {
        title: t(isMap ? "delete_map_title" : "delete_title", values),
        button: t("delete"),
        texts: [
          t(isMap ? "delete_map_text" : "delete_text", values),
          alsoSessions ? drained : t("delete_refused"),
        ],
        choice: t("drain_sessions"),
      };
    }
  }
}

function perform(
  server: string,
  { name: mapName }: RadarMap,
  { kind, version: number }: MapAction,
  { alsoSessions, share }: { alsoSessions: boolean; share: number },
): Promise<unknown> {
  const version = BigInt(number);
  const { method } = MapService;
  switch (kind) {
    case "activate":
      return call(server, method.activateMapVersion, { mapName, version, moveSessions: alsoSessions });
    case "roll_back":
      return call(server, method.rollBackMap, { mapName, moveSessions: alsoSessions });
    case "canary":
      return call(server, method.setMapCanary, { mapName, version, share });
    case "end_canary":
      return call(server, method.setMapCanary, { mapName });
    case "update": {
      const header = { mapName, baseVersion: version, method: MapBuildMethod.UPDATE };
      return call(server, method.startMapBuild, { message: { case: "header", value: header } });
    }
    case "delete":
      return call(server, method.deleteMapVersion, { mapName, version, drainSessions: alsoSessions });
    case "delete_map":
      return call(server, method.deleteMap, { mapName, drainSessions: alsoSessions });
  }
}
