import { useCallback, useEffect, useState } from "preact/hooks";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";

/** What asking again does not change. */
const FINAL = new Set<number>([
  Code.Unauthenticated,
  Code.PermissionDenied,
  Code.NotFound,
  Code.Unimplemented,
]);

/** Something that is read from a server: what there is of it, and what went wrong. */
export interface Loaded<T> {
  value?: T;
  failure?: CallFailure;
  reload: () => void;
}

/**
 * Reads when `keys` change, on `reload`, and every `periodMs`. After a failure the last value stays, so
 * that a short break empties no view.
 */
export function useCall<T>(
  read: (signal: AbortSignal) => Promise<T>,
  keys: readonly unknown[],
  periodMs = 0,
): Loaded<T> {
  const [round, setRound] = useState(0);
  const [loaded, setLoaded] = useState<Omit<Loaded<T>, "reload">>({});
  const reload = useCallback(() => setRound((n) => n + 1), []);

  useEffect(() => setLoaded({}), keys);
  useEffect(() => {
    const stop = new AbortController();
    let timer: ReturnType<typeof setTimeout> | undefined;
    const again = (): void => {
      if (periodMs > 0 && !stop.signal.aborted) timer = setTimeout(run, periodMs);
    };
    const run = (): void => {
      read(stop.signal).then(
        (value) => {
          if (stop.signal.aborted) return;
          setLoaded({ value });
          again();
        },
        (error: unknown) => {
          const failure = failureOf(error);
          if (stop.signal.aborted) return;
          setLoaded((old) => ({ ...old, failure }));
          if (!FINAL.has(failure.code)) again();
        },
      );
    };
    run();
    return () => {
      stop.abort();
      clearTimeout(timer);
    };
  }, [...keys, round]);
  return { ...loaded, reload };
}
