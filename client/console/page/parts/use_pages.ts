import { useState } from "preact/hooks";
import { type Loaded, useCall } from "./use_call.ts";

interface Page<T> {
  entries: readonly T[];
  /** Empty on the last one. */
  nextPageToken: string;
}

/** The entries of the first pages; `more` reads one page more, where there is one. */
export interface LoadedPages<T> extends Loaded<readonly T[]> {
  more: (() => void) | undefined;
}

/** Reads lists page by page, again every `periodMs`. */
export function usePages<T>(
  read: (pageToken: string, signal: AbortSignal) => Promise<Page<T>>,
  keys: readonly unknown[],
  periodMs: number,
): LoadedPages<T> {
  const [pageCount, setPageCount] = useState(1);
  const loaded = useCall(
    async (signal) => {
      const entries: T[] = [];
      let token = "";
      for (let i = 0; i < pageCount; i++) {
        const page = await read(token, signal);
        entries.push(...page.entries);
        token = page.nextPageToken;
        if (token === "") break;
      }
      return { entries, hasMore: token !== "" };
    },
    [...keys, pageCount],
    periodMs,
  );
  return {
    ...(loaded.value ? { value: loaded.value.entries } : {}),
    ...(loaded.failure ? { failure: loaded.failure } : {}),
    reload: loaded.reload,
    more: loaded.value?.hasMore ? () => setPageCount((n) => n + 1) : undefined,
  };
}
