import { AdminService, type Operation } from "proto/dcloc/v1/admin_service_pb.ts";
import { DataTable } from "../parts/data_table.tsx";
import { FailureNotice, Loading } from "../parts/notice.tsx";
import { usePages } from "../parts/use_pages.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { dateTime, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";

const PERIOD_MS = 5_000;
const PAGE_SIZE = 50;

/** What was changed on a server, by whom, and whether it succeeded; newest first. */
export function Operations({ server }: { server: string }) {
  const { value, failure, reload, more } = usePages<Operation>(
    async (pageToken, signal) => {
      const request = { pageSize: PAGE_SIZE, pageToken };
      const page = await call(server, AdminService.method.listOperations, request, signal);
      return { entries: page.operations, nextPageToken: page.nextPageToken };
    },
    [server],
    PERIOD_MS,
  );
  return (
    <>
      <h3>{t("operations")}</h3>
      {failure && !value && <FailureNotice failure={failure} retry={reload} />}
      {!failure && !value && <Loading />}
      {value?.length === 0 && <p class="hint">{t("no_operations")}</p>}
      {value && value.length > 0 && <OperationTable operations={value} />}
      {more && <button onClick={more}>{t("more")}</button>}
      <p class="hint">{t("operations_hint")}</p>
    </>
  );
}

function OperationTable({ operations }: { operations: readonly Operation[] }) {
  return (
    <DataTable
      label={t("operations")}
      columns={[
        { name: t("time") },
        { name: t("who") },
        { name: t("call") },
        { name: t("asked_for"), kind: "free-text" },
        { name: t("result"), kind: "free-text" },
      ]}
      head={1}
      rows={operations.map((operation) => ({
        key: String(operation.number),
        cells: [
          dateTime(Number(operation.time?.seconds ?? 0n) * 1000),
          <>
            {shownName(operation.principal)} <span class="soft">{shownName(operation.role)}</span>
          </>,
          <span title={shownName(operation.peer)}>{shownName(operation.method.split(".").at(-1)!)}</span>,
          shortened(operation.request, 400),
          <Result operation={operation} />,
        ],
      }))}
    />
  );
}

function Result({ operation: { statusCode, statusMessage } }: { operation: Operation }) {
  if (statusCode === 0) return <>{t("done")}</>;
  return <span class="fault">{t("failed_with", { message: shortened(statusMessage, 400) })}</span>;
}
