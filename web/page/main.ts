import "./style.css";
import { hasWebGl2, noWebGl2 } from "./problems.ts";
import { startTheme } from "./theme.ts";
import { readUrl } from "./url_state.ts";

const root = document.querySelector<HTMLElement>("#page");
if (!root) throw new Error("index.html has no #page");

startTheme();

// The controls come in beside the picture: the first surface does not wait for them.
const controls = import("./components.ts");
controls.catch(() => {}); // shown as plain elements; the picture works without

const { volume, src } = readUrl(location.search);
if (volume || src) {
  if (hasWebGl2()) {
    const [{ VolumePage }, { openTarget }] = await Promise.all([
      import("./volume_page.ts"),
      import("./open_target.ts"),
    ]);
    new VolumePage(root, openTarget(volume, src));
  } else {
    const [{ render }, { problemCard }] = await Promise.all([import("lit"), import("./chrome.ts")]);
    const retry = () => location.reload();
    render(problemCard(noWebGl2, { retry }), root);
  }
} else {
  const { Catalog } = await import("./catalog.ts");
  new Catalog(root);
}
