import { t } from "../texts/texts.ts";
import { CallFailure, Code } from "./failure.ts";

/** What an answer has to have; a server that leaves it out is broken, or far newer. */
export function expected<T>(value: T | undefined): T {
  if (value === undefined) throw new CallFailure(Code.Internal, t("answer_lacks"));
  return value;
}
