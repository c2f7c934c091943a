import "./style.css";
import { compiledView } from "../viewer/index.ts";
import { openTarget } from "./open_target.ts";
import { startTheme } from "./theme.ts";
import { readUrl } from "./url_state.ts";
import { VolumePage } from "./volume_page.ts";

/** Milliseconds after which the controls come even without a picture. */
const latestControls = 2000;

const root = document.querySelector<HTMLElement>("#page");
if (!root) throw new Error("index.html has no #page");

const { volume, src } = readUrl(location.search);
const isOpening = volume !== undefined || src !== undefined;
// Asked for before anything else; a failure is reported by whoever needs it.
if (isOpening) compiledView().catch(() => {});

startTheme();

if (!isOpening) {
  const { Catalog } = await import("./catalog.ts");
  new Catalog(root);
} else {
  // The controls' code is a few times the size of the rest: the first surface goes first.
  const page = new VolumePage(root, openTarget(volume, src));
  await Promise.race([page.firstSight, new Promise((late) => setTimeout(late, latestControls))]);
}

// Should the controls not come, the picture and the keyboard work without.
await import("./components.ts");
