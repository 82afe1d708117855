import { type Health, SourceFault } from "proto/dcloc/v1/localization_service_pb.ts";
import { shownName } from "../texts/shortened.ts";
import { numbered, t } from "../texts/texts.ts";

/** A file may list any number of them. */
const MAX_RADAR_COUNT = 40;

/** Which of a vehicle's sources take part, and what is wrong with the others. */
export function Sources({ health }: { health: Health | undefined }) {
  if (!health) return null;
  const sources = [
    { name: t("wheel_speed"), source: health.wheelSpeed },
    { name: t("yaw_rate"), source: health.yawRate },
    ...health.radars.slice(0, MAX_RADAR_COUNT).map((source) => ({ name: source.radarId, source })),
  ];
  return (
    <section aria-labelledby="sources">
      <h2 id="sources">{t("sources")}</h2>
      <ul class="sources">
        {sources.map(({ name, source }) => {
          if (!source) return null;
          const isWell = source.used && source.fault <= SourceFault.NONE;
          return (
            <li key={name} class={isWell ? "well" : "ill"}>
              <strong>{shownName(name)}</strong>
              <span>{t(source.used ? "used" : "set_aside")}</span>
              <span class="soft">
                {source.fault > SourceFault.NONE &&
                  numbered("fault_", source.fault, t("unknown_value", { value: source.fault }))}
              </span>
            </li>
          );
        })}
      </ul>
    </section>
  );
}
