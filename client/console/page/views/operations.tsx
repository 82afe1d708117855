import { AdminService, type Operation } from "proto/dcloc/v1/admin_service_pb.ts";
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
    <div class="table-frame" role="region" aria-label={t("operations")} tabIndex={0}>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("time")}</th>
            <th scope="col">{t("who")}</th>
            <th scope="col">{t("call")}</th>
            <th scope="col">{t("asked_for")}</th>
            <th scope="col">{t("result")}</th>
          </tr>
        </thead>
        <tbody>
          {operations.map((operation) => (
            <tr key={String(operation.number)}>
              <td>{dateTime(Number(operation.time?.seconds ?? 0n) * 1000)}</td>
              <th scope="row">
                {shownName(operation.principal)} <span class="soft">{operation.role}</span>
              </th>
              <td title={operation.peer}>{operation.method.split(".").at(-1)}</td>
              <td class="free-text">{shortened(operation.request, 400)}</td>
              <td class="free-text">
                {operation.statusCode === 0 ? (
                  t("done")
                ) : (
                  <span class="fault">{t("failed_with", { message: operation.statusMessage })}</span>
                )}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
