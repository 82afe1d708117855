import { useState } from "preact/hooks";
import { type MapBuild, MapBuildState, MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { Dialog } from "../parts/dialog.tsx";
import { failureText } from "../parts/notice.tsx";
import { useCall } from "../parts/use_call.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { count, numbered, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";

const PERIOD_MS = 5_000;
const MAX_SHOWN_COUNT = 20;
/** Of the calls that a token without the right, or an older server, refuses as the list does. */
const TOLD_ELSEWHERE = new Set<number>([Code.PermissionDenied, Code.Unimplemented]);

/** Builds that a server makes of scans; nothing is shown where there are none. */
export function Builds({ server }: { server: string }) {
  const [chosen, setChosen] = useState<MapBuild>();
  const { value, failure, reload } = useCall(
    async (signal) => (await call(server, MapService.method.listMapBuilds, {}, signal)).builds,
    [server],
    PERIOD_MS,
  );
  if (!value && failure && !TOLD_ELSEWHERE.has(failure.code)) {
    return <p class="hint">{t("builds_unknown", { message: shortened(failureText(failure)) })}</p>;
  }
  if (!value || value.length === 0) return null;
  return (
    <>
      <h2>{t("builds")}</h2>
      <ul class="builds">
        {value.slice(0, MAX_SHOWN_COUNT).map((build) => (
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
    </>
  );
}

function Row({ build, onCancel }: { build: MapBuild; onCancel: () => void }) {
  const isRunning = build.state === MapBuildState.RUNNING;
  const name = shownName(build.mapName);
  const scans = t("build_scans", {
    done: count(Number(build.doneScanCount)),
    count: count(Number(build.scanCount)),
  });
  return (
    <li>
      <strong>{name}</strong>
      <span>{numbered("build_state_", build.state, t("unknown_value", { value: build.state }))}</span>
      {isRunning && (
        <progress
          aria-label={name}
          max={Math.max(1, Number(build.scanCount))}
          value={Number(build.doneScanCount)}
        />
      )}
      <span class="soft">{shortened(build.errorMessage) || scans}</span>
      {isRunning && (
        <button class="danger" aria-label={`${t("cancel_build")}: ${name}`} onClick={onCancel}>
          {t("cancel_build")} …
        </button>
      )}
    </li>
  );
}
