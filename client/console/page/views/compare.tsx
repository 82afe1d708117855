import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { MapService, type MapVersion } from "proto/dcloc/v1/map_service_pb.ts";
import { Comparison } from "../compare/comparison.ts";
import { drawDifference } from "../compare/draw_difference.ts";
import { SAME_M } from "../compare/match.ts";
import type { Bounds } from "../map/camera.ts";
import { extentOf } from "../map/extent.ts";
import { MapCanvas } from "../map/map_canvas.tsx";
import { Link } from "../parts/link.tsx";
import { FailureNotice, Loading, Notice } from "../parts/notice.tsx";
import { go, pathOf } from "../parts/route.ts";
import { useCall } from "../parts/use_call.ts";
import { count, dateTime, decimals, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";

const SHOW_MS = 250;

interface Props {
  server: string;
  map: string;
  from: number;
  to: number;
}

export const comparePath = ({ server, map, from, to }: Props): string =>
  pathOf("compare", server, map, from, to);

function union(a: Bounds | undefined, b: Bounds | undefined): Bounds | undefined {
  if (!a || !b) return a ?? b;
  return {
    minX: Math.min(a.minX, b.minX),
    minY: Math.min(a.minY, b.minY),
    maxX: Math.max(a.maxX, b.maxX),
    maxY: Math.max(a.maxY, b.maxY),
  };
}

/** Compares while the view is open; its user is shown again some times a second. */
function useComparison({ server, map, from, to }: Props, extent: Bounds | undefined) {
  const made = useRef<Comparison>();
  const [tick, setTick] = useState(0);
  useEffect(() => {
    if (!extent) return undefined;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const show = (): void => {
      timer ??= setTimeout(() => {
        timer = undefined;
        setTick((n) => n + 1);
      }, SHOW_MS);
    };
    made.current = new Comparison({ server, map, from, to }, extent, show);
    show();
    return () => {
      clearTimeout(timer);
      made.current?.close();
      made.current = undefined;
    };
  }, [server, map, from, to, extent]);
  return { comparison: made.current, tick };
}

/** Two versions of a map on one another: what only one of them has, and what both have. */
export function CompareView(props: Props) {
  const { server, map, from, to } = props;
  const loaded = useCall(
    async (signal) => {
      const request = { mapName: map, pageSize: 1000 };
      return (await call(server, MapService.method.listMapVersions, request, signal)).versions;
    },
    [server, map],
  );
  const versions = loaded.value;
  const find = (number: number): MapVersion | undefined =>
    versions?.find(({ version }) => Number(version) === number);
  const [first, second] = [find(from), find(to)];
  const extent = useMemo(
    () => union(extentOf(first?.info), extentOf(second?.info)),
    [first?.sha256, second?.sha256],
  );
  const [isDetailed, setDetailed] = useState(true);
  const { comparison, tick } = useComparison(props, first && second ? extent : undefined);
  if (!versions) {
    return loaded.failure ? <FailureNotice failure={loaded.failure} retry={loaded.reload} /> : <Loading />;
  }
  if (!first || !second) {
    return (
      <Notice title={t("not_found_title")}>
        <p>{t("compare_title", { map, from, to })}</p>
        <Link to={pathOf("maps", server, map)}>{map}</Link>
      </Notice>
    );
  }
  return (
    <div class="split">
      <section class="side wide" aria-label={t("compare")}>
        <div class="side-head">
          <p class="crumbs">
            <Link to="/maps">{t("maps")}</Link> / <Link to={pathOf("maps", server, map)}>{map}</Link>
          </p>
          <h1>{t("compare_title", { map, from, to })}</h1>
          <Choice {...props} versions={versions} />
        </div>
        <div class="compare-facts">
          {comparison && <Differences {...props} comparison={comparison} />}
          <p class="hint">{t("compare_same", { distance: decimals(SAME_M, 1) })}</p>
          <CopyLink />
        </div>
      </section>
      <div class="stage">
        <MapCanvas
          map={undefined}
          extent={extent}
          overlay={(context, camera, palette) => {
            if (comparison) setDetailed(drawDifference(context, camera, palette, comparison));
          }}
          vehicles={() => []}
          tick={tick}
        />
        <div class="legend">
          <span>
            <span class="swatch only-from" aria-hidden="true" /> {t("compare_only_from", { version: from })}
          </span>
          <span>
            <span class="swatch only-to" aria-hidden="true" /> {t("compare_only_to", { version: to })}
          </span>
          <span>
            <span class="swatch both" aria-hidden="true" /> {t("compare_both")}
          </span>
          {!isDetailed && <span class="soft">{t("compare_zoom")}</span>}
        </div>
      </div>
    </div>
  );
}

function Choice({ versions, ...chosen }: Props & { versions: readonly MapVersion[] }) {
  const choose = (part: Partial<Props>): void => go(comparePath({ ...chosen, ...part }));
  const options = versions.map(({ version, createTime }) => (
    <option key={String(version)} value={Number(version)}>
      {t("version_n", { version: Number(version) })} · {dateTime(Number(createTime?.seconds ?? 0n) * 1000)}
    </option>
  ));
  return (
    <div class="compare-choice">
      <label>
        {t("compare_from")}
        <select value={chosen.from} onChange={(e) => choose({ from: Number(e.currentTarget.value) })}>
          {options}
        </select>
      </label>
      <label>
        {t("compare_to")}
        <select value={chosen.to} onChange={(e) => choose({ to: Number(e.currentTarget.value) })}>
          {options}
        </select>
      </label>
      <button onClick={() => choose({ from: chosen.to, to: chosen.from })}>{t("swap")}</button>
    </div>
  );
}

function Differences({ comparison, from, to }: Props & { comparison: Comparison }) {
  const { counts, doneCount, squares, partCount, isCut, failure } = comparison;
  const rows: [string, string, number][] = [
    ["only-from", t("compare_only_from", { version: from }), counts.onlyFrom],
    ["only-to", t("compare_only_to", { version: to }), counts.onlyTo],
    ["both", t("compare_both"), counts.both],
  ];
  const progress = t("compare_progress", { done: count(doneCount), count: count(squares.size) });
  return (
    <>
      <table aria-label={t("compare_counts")}>
        <tbody>
          {rows.map(([name, text, value]) => (
            <tr key={name}>
              <th scope="row">
                <span class={`swatch ${name}`} aria-hidden="true" /> {text}
              </th>
              <td class="number">{count(value)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="soft small" role="status">
        {progress}
      </p>
      {doneCount < squares.size && <progress value={doneCount} max={squares.size} aria-label={progress} />}
      {partCount > 0 && <p class="hint">{t("compare_partly", { count: count(partCount) })}</p>}
      {isCut && <p class="hint">{t("compare_too_large", { count: count(squares.size) })}</p>}
      {failure && (
        <p class="fault" role="alert">
          {t("compare_failed", { message: failure.message || t("cut_text") })}
        </p>
      )}
    </>
  );
}

/** The address is the link: it names both versions. */
function CopyLink() {
  const [isCopied, setCopied] = useState(false);
  const copy = (): void => {
    // Only pages over TLS, or of this machine, may write the clipboard.
    navigator.clipboard?.writeText(location.href).then(
      () => setCopied(true),
      () => undefined,
    );
  };
  return (
    <div class="button-row">
      {navigator.clipboard && <button onClick={copy}>{t(isCopied ? "link_copied" : "compare_link")}</button>}
    </div>
  );
}
