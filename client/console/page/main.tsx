import "@fontsource-variable/inter/wght.css";
import "uplot/dist/uPlot.min.css";
import "./style.css";
import { render } from "preact";
import { Shell } from "./shell.tsx";
import { startTheme } from "./theme.ts";
import { startTenant } from "./wire/tenant.ts";
import { chooseLanguage, currentLanguage } from "./texts/texts.ts";

startTheme();
startTenant();
chooseLanguage(currentLanguage());
render(<Shell />, document.getElementById("page")!);
