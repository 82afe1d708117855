import { useState } from "preact/hooks";
import { AdminService, type Identity } from "proto/dcloc/v1/admin_service_pb.ts";
import { DataTable } from "../parts/data_table.tsx";
import { Dialog } from "../parts/dialog.tsx";
import { FailureNotice, Loading } from "../parts/notice.tsx";
import { usePages } from "../parts/use_pages.ts";
import { shownName } from "../texts/shortened.ts";
import { dateTime, numbered, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { Code } from "../wire/failure.ts";

const PERIOD_MS = 10_000;
const PAGE_SIZE = 100;

/** Who is let in by a server, in which role; what lets them in can be revoked. */
export function Identities({ server }: { server: string }) {
  const [chosen, setChosen] = useState<Identity>();
  const { value, failure, reload, more } = usePages<Identity>(
    async (pageToken, signal) => {
      const request = { pageSize: PAGE_SIZE, pageToken };
      const page = await call(server, AdminService.method.listIdentities, request, signal);
      return { entries: page.identities, nextPageToken: page.nextPageToken };
    },
    [server],
    PERIOD_MS,
  );
  const isDenied = failure?.code === Code.PermissionDenied;
  return (
    <>
      <h3>{t("identities")}</h3>
      {failure && !value && isDenied && <p class="hint">{t("identities_denied")}</p>}
      {failure && !value && !isDenied && <FailureNotice failure={failure} retry={reload} />}
      {!failure && !value && <Loading />}
      {value?.length === 0 && <p class="hint">{t("no_identities")}</p>}
      {value && value.length > 0 && <IdentityTable identities={value} onRevoke={setChosen} />}
      {more && <button onClick={more}>{t("more")}</button>}
      <p class="hint">{t("identities_hint")}</p>
      {chosen && (
        <Dialog
          title={t("revoke_title", { name: shownName(chosen.name) })}
          action={t("revoke")}
          isDangerous
          onClose={() => setChosen(undefined)}
          onDo={() =>
            call(server, AdminService.method.revokeIdentity, { id: chosen.id }).then(reload)
          }
        >
          <p>{t("revoke_text")}</p>
        </Dialog>
      )}
    </>
  );
}

interface TableProps {
  identities: readonly Identity[];
  onRevoke: (identity: Identity) => void;
}

function IdentityTable({ identities, onRevoke }: TableProps) {
  return (
    <DataTable
      label={t("identities")}
      columns={[
        { name: t("name") },
        { name: t("role") },
        { name: t("tenant") },
        { name: t("proof") },
        { name: t("expires") },
        { name: t("revoke") },
      ]}
      rows={identities.map((identity) => ({
        key: String(identity.id),
        cells: [
          shownName(identity.name),
          shownName(identity.role),
          shownName(identity.tenant) || "–",
          numbered("proof_", identity.proof, t("proof_unknown", { proof: identity.proof })),
          endOf(identity),
          !identity.revokeTime && (
            <button
              class="danger"
              aria-label={`${t("revoke")}: ${shownName(identity.name)}`}
              onClick={() => onRevoke(identity)}
            >
              {t("revoke")} …
            </button>
          ),
        ],
      }))}
    />
  );
}

function endOf({ revokeTime, expireTime }: Identity): string {
  const text = (time: { seconds: bigint }): string => dateTime(Number(time.seconds) * 1000);
  if (revokeTime) return t("revoked_at", { time: text(revokeTime) });
  return expireTime ? text(expireTime) : t("never");
}
