import "./style.css";
import { compiledRenderer } from "../viewer/index.ts";
import { openTarget } from "./open_target.ts";
import { startTheme } from "./theme.ts";
import { readUrl } from "./url_state.ts";
import { VolumePage } from "./volume_page.ts";

/** Milliseconds after which the controls come even without a picture. */
const latestControls = 2000;

const root = document.querySelector<HTMLElement>("#page");
if (!root) throw new Error("index.html has no #page");
root.replaceChildren();

const { volume, src } = readUrl(location.search);
const isOpening = volume !== undefined || src !== undefined;
// Asked for before anything else; a failure is reported by whoever needs it.
if (isOpening) compiledRenderer().catch(() => {});

startTheme();

try {
  if (!isOpening) {
    const { Catalog } = await import("./catalog.ts");
    new Catalog(root);
  } else {
    // The controls' code is a few times the size of the rest: the first surface goes first.
    const page = new VolumePage(root, openTarget(volume, src));
    await Promise.race([
      page.firstVisibility,
      new Promise((late) => setTimeout(late, latestControls)),
    ]);
  }
  // Should the controls not come, the picture and the keyboard work without.
  await import("./components.ts");
} catch (error) {
  sayIncomplete();
  throw error;
}

/** A part of the page's program did not load: what is here goes on, over a message. */
function sayIncomplete(): void {
  const message = document.createElement("div");
  message.className = "page-incomplete";
  message.setAttribute("role", "alert");
  const reload = document.createElement("button");
  reload.type = "button";
  reload.textContent = "Reload";
  reload.addEventListener("click", () => location.reload());
  message.append(
    "A part of this page did not load: the link broke, or the page was replaced on its server. ",
    reload,
  );
  document.body.append(message);
}
