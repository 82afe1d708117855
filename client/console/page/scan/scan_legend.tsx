import { decimals, t } from "../texts/texts.ts";
import { NEAR_M } from "./surroundings.ts";

export function ScanLegend() {
  return (
    <p class="scan-legend">
      <span>
        <i class="target near" aria-hidden="true" /> {t("target_near", { distance: decimals(NEAR_M, 0) })}
      </span>
      <span>
        <i class="target far" aria-hidden="true" /> {t("target_far")}
      </span>
      <span>
        <i class="swatch rates" aria-hidden="true" /> {t("target_rates")}
      </span>
    </p>
  );
}
