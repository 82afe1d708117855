import { useEffect, useState } from "preact/hooks";
import { AdminService } from "proto/dcloc/v1/admin_service_pb.ts";
import { numbered, t } from "../texts/texts.ts";
import { call } from "../wire/calls.ts";
import { type CallFailure, Code, failureOf } from "../wire/failure.ts";
import { type ProposalDraft, isPlaced, poseOf } from "./proposal.ts";

interface Props {
  server: string;
  session: string;
  /** What is chosen so far; a click on the map chooses the place. */
  proposal: ProposalDraft;
  onChange: (proposal: ProposalDraft) => void;
  onClose: () => void;
}

/** Tells a session where somebody thinks that its vehicle was at its last scan. */
export function ProposePose({ server, session, proposal, onChange, onClose }: Props) {
  const [answer, setAnswer] = useState("");
  const [failure, setFailure] = useState<CallFailure>();
  const [isBusy, setBusy] = useState(false);
  const propose = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (!isPlaced(proposal) || isBusy) return;
    setBusy(true);
    setAnswer("");
    setFailure(undefined);
    try {
      const request = { sessionId: session, pose: poseOf(proposal) };
      const { answer: told } = await call(server, AdminService.method.proposePose, request);
      const use = told?.use ?? 0;
      setAnswer(numbered("proposed_", use, t("proposed_unknown", { use })));
    } catch (error) {
      setFailure(failureOf(error));
    }
    setBusy(false);
  };
  const change = (values: ProposalDraft): void => onChange({ ...proposal, ...values });
  return (
    <section aria-label={t("propose_pose")}>
      <h2>{t("propose_pose")}</h2>
      <p class="hint">{t("propose_hint")}</p>
      <form class="proposal" onSubmit={(event) => void propose(event)}>
        <NumberField label={t("place_x")} value={proposal.x} onChange={(x) => change({ x })} />
        <NumberField label={t("place_y")} value={proposal.y} onChange={(y) => change({ y })} />
        <NumberField
          label={t("heading_deg")}
          value={proposal.yawDeg}
          range={[-360, 360]}
          isOptional
          onChange={(yawDeg) => change({ yawDeg })}
        />
        <NumberField
          label={t("spread_m")}
          value={proposal.sigmaM}
          range={[0.1, 10_000]}
          onChange={(sigmaM) => change({ sigmaM })}
        />
        <div class="buttons">
          <button type="button" onClick={onClose}>
            {t("close")}
          </button>
          <button type="submit" class="primary" disabled={isBusy || !isPlaced(proposal)}>
            {t("propose")}
          </button>
        </div>
      </form>
      <p role="status">{answer}</p>
      {failure && (
        <p class="fault" role="alert">
          {wordsOf(failure)}
        </p>
      )}
    </section>
  );
}

function wordsOf({ code, message }: CallFailure): string {
  if (code === Code.PermissionDenied) return t("denied_text", { message });
  if (code === Code.Unimplemented) return t("older_server");
  return message || t("cut_text");
}

interface FieldProps {
  label: string;
  value: number | undefined;
  range?: [number, number];
  isOptional?: boolean;
  onChange: (value: number | undefined) => void;
}

const textOf = (value: number | undefined): string =>
  value === undefined ? "" : String(Math.round(value * 100) / 100);

const numberOf = (text: string): number | undefined =>
  text === "" || !Number.isFinite(Number(text)) ? undefined : Number(text);

function NumberField({ label, value, range = [-1e8, 1e8], isOptional = false, onChange }: FieldProps) {
  const [min, max] = range;
  // What is being typed stays as it is; a value from elsewhere, as from a click, replaces it.
  const [text, setText] = useState(textOf(value));
  useEffect(() => {
    if (numberOf(text) !== value) setText(textOf(value));
  }, [value]);
  return (
    <label>
      {label}
      <input
        type="number"
        step="any"
        min={min}
        max={max}
        required={!isOptional}
        value={text}
        onInput={({ currentTarget: { value: typed } }) => {
          setText(typed);
          onChange(numberOf(typed));
        }}
      />
    </label>
  );
}
