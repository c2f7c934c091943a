import "./style.css";
import { startLanguage } from "../texts/language.ts";
import { compiledRenderer } from "../viewer/renderer_program.ts";
import { openTarget } from "./address/open_target.ts";
import { readUrl } from "./address/url_state.ts";
import { loadPart, retryStyles, showIncomplete } from "./shell/load_part.ts";
import { startTheme } from "./shell/theme.ts";
import { VolumePage } from "./volume/volume_page.ts";

/** After this time (ms) the controls load even if there is no picture yet. */
const latestControls = 2000;

const root = document.querySelector<HTMLElement>("#page");
if (!root) throw new Error("index.html has no #page");
root.replaceChildren();

const url = readUrl(location.search);
const target = openTarget(url);
// This request comes first; if it fails, its first user reports the error.
if (target) compiledRenderer().catch(() => {});

startTheme();
retryStyles();

try {
  await startLanguage();
  if (!target) {
    const { start } = await loadPart(() => import("./start.ts"));
    await start(root, url);
  } else {
    // The code of the controls is several times larger than the rest, so it loads after the first
    // surface.
    const page = new VolumePage(root, target);
    await Promise.race([
      page.firstContent,
      new Promise((late) => setTimeout(late, latestControls)),
    ]);
    const components = loadPart(() => import("./shell/components.ts"));
    await loadAll([page.loadOverlay(), components, loadDeviceFiles(page)]);
  }
} catch (error) {
  showIncomplete();
  throw error;
}

// Until device_files.ts has loaded, a dropped file must not replace the page.
for (const type of ["dragover", "drop"]) {
  window.addEventListener(type, (event) => {
    // Text may be dropped into fields.
    if ((event as DragEvent).dataTransfer?.types.includes("Files")) event.preventDefault();
  });
}

/** The code that opens files of this device is loaded after the first surface as well. */
async function loadDeviceFiles(page: VolumePage): Promise<void> {
  const { DeviceFiles } = await loadPart(() => import("./device/device_files.ts"));
  new DeviceFiles(page.root, page);
}

/** Each part works without the others. The picture and the keyboard need none of them. */
async function loadAll(parts: readonly Promise<unknown>[]): Promise<void> {
  const failed = (await Promise.allSettled(parts)).find(({ status }) => status === "rejected");
  if (failed?.status === "rejected") throw failed.reason;
}
