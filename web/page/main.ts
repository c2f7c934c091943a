import "./style.css";
import { render } from "lit";
import { compiledView } from "../viewer/index.ts";
import { problemCard } from "./chrome.ts";
import { openTarget } from "./open_target.ts";
import { hasWebGl2, noWebGl2 } from "./problems.ts";
import { startTheme } from "./theme.ts";
import { readUrl } from "./url_state.ts";
import { VolumePage } from "./volume_page.ts";

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
} else if (hasWebGl2()) {
  new VolumePage(root, openTarget(volume, src));
} else {
  render(problemCard(noWebGl2, { retry: () => location.reload() }), root);
}

// The controls come in beside the picture: the first surface does not wait for them. Should they
// not come, the picture and the keyboard work without.
await import("./components.ts");
