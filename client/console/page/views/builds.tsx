import { useState } from "preact/hooks";
import { type MapBuild, MapBuildState, MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { Dialog } from "../parts/dialog.tsx";
import { failureText } from "../parts/notice.tsx";
import { useCall } from "../parts/use_call.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { count, decimals, numbered, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";

const PERIOD_MS = 5_000;
const MAX_SHOWN_COUNT = 20;
const MAX_SHOWN_DRIVES = 5;
/** What the list of maps fails with as well: no right, an older server, none that answers. */
const TOLD_ELSEWHERE = new Set<number>([Code.PermissionDenied, Code.Unimplemented, Code.Unavailable]);

interface Props {
  server: string;
  /** Only those of this map. */
  map?: string;
  /** Read anew when it changes. */
  round?: number;
}

/** Jobs that make versions of maps; nothing is shown where there are none. */
export function Builds({ server, map, round = 0 }: Props) {
  const [chosen, setChosen] = useState<MapBuild>();
  const { value, failure, reload } = useCall(
    async (signal) => (await call(server, MapService.method.listMapBuilds, {}, signal)).builds,
    [server, round],
    PERIOD_MS,
  );
  const builds = value?.filter((build) => map === undefined || build.mapName === map) ?? [];
  if (!value && failure && !TOLD_ELSEWHERE.has(failure.code)) {
    return <p class="hint">{t("builds_unknown", { message: shortened(failureText(failure)) })}</p>;
  }
  if (builds.length === 0) return null;
  return (
    <section class="builds" aria-label={t("builds")}>
      <h2>{t("builds")}</h2>
      <ul>
        {builds.slice(0, MAX_SHOWN_COUNT).map((build) => (
          <Row key={build.buildId} build={build} onCancel={() => setChosen(build)} />
        ))}
      </ul>
      {chosen && (
        <Dialog
          title={t("cancel_build_title", { map: shownName(chosen.mapName) })}
          action={t("cancel_build")}
          isDangerous
          onClose={() => setChosen(undefined)}
          onDo={() =>
            call(server, MapService.method.cancelMapBuild, { buildId: chosen.buildId }).then(reload)
          }
        >
          <p>{t("cancel_build_text")}</p>
        </Dialog>
      )}
    </section>
  );
}

function Row({ build, onCancel }: { build: MapBuild; onCancel: () => void }) {
  const isRunning = build.state === MapBuildState.RUNNING;
  const name = shownName(build.mapName);
  return (
    <li>
      <strong>{name}</strong>
      <span>{numbered("build_state_", build.state, t("unknown_value", { value: build.state }))}</span>
      <span class="soft">{numbered("build_method_", build.method, "")}</span>
      {isRunning && <progress aria-label={name} max={1} value={shareOf(build)} />}
      {isRunning && (
        <button class="danger" aria-label={`${t("cancel_build")}: ${name}`} onClick={onCancel}>
          {t("cancel_build")} …
        </button>
      )}
      {linesOf(build).map((line, i) => (
        <p key={i} class="soft">
          {line}
        </p>
      ))}
    </li>
  );
}

/** Of its stage where it names one, else of its scans; a server may say anything. */
function shareOf({ stage, stageShare, doneScanCount, scanCount }: MapBuild): number {
  const share = stage === "" ? Number(doneScanCount) / Math.max(1, Number(scanCount)) : stageShare;
  return share >= 0 && share <= 1 ? share : 0;
}

/** What is known of it, in sentences. */
function linesOf(build: MapBuild): string[] {
  const { state, stage, errorMessage, version, update, drives, attemptCount } = build;
  const lines: string[] = [];
  if (errorMessage !== "") lines.push(shortened(errorMessage, 1000));
  else if (version) lines.push(t("build_made", { version: String(version.version) }));
  else if (stage !== "" && state === MapBuildState.RUNNING) {
    const percent = count(100 * shareOf(build));
    lines.push(t("build_stage", { stage: shortened(stage), percent }));
  } else {
    const counts = { done: count(Number(build.doneScanCount)), count: count(Number(build.scanCount)) };
    lines.push(t("build_scans", counts));
  }
  if (attemptCount > 1) lines.push(t("build_attempt", { count: count(attemptCount - 1) }));
  if (update) {
    lines.push(
      t("build_judged", {
        added: count(Number(update.addedCount)),
        removed: count(Number(update.removedCount)),
        old: decimals(update.oldErrorM, 3),
        new: decimals(update.newErrorM, 3),
      }),
    );
  }
  const leftOut = drives.filter((drive) => !drive.inMap);
  if (drives.length > 0) {
    const used = count(drives.length - leftOut.length);
    lines.push(t("build_drives", { used, count: count(drives.length) }));
  }
  for (const { name, reason } of leftOut.slice(0, MAX_SHOWN_DRIVES)) {
    lines.push(t("build_drive_left_out", { drive: shortened(name), reason: shortened(reason) }));
  }
  return lines;
}
