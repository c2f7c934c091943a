// The program of a single page: viewer, WebAssembly and a store or a bundle in one HTML file, opened from
// file://. The build generates single.html from it; web/device/save_single_page.ts adds the store or the bundle.
import "./style.css";
import "./shell/components.ts";
import { bundleScene } from "../scene/scene_source.ts";
import { BlobSource } from "../stream/blob_source.ts";
import { beginsAsBundle } from "../stream/transfer.ts";
import { startLanguage } from "../texts/language.ts";
import type { Target } from "./address/target.ts";
import { startTheme } from "./shell/theme.ts";
import { VolumePage } from "./volume/volume_page.ts";

const root = document.querySelector<HTMLElement>("#page");
if (!root) throw new Error("the page has no #page");
root.replaceChildren();

// Some browsers do not let a page of a file change its address. The address bar then has no view.
const replace = history.replaceState.bind(history);
history.replaceState = (...call) => {
  try {
    replace(...call);
  } catch {}
};

const parts = [...document.querySelectorAll("script[data-store]")].map((part) => {
  const bytes = Uint8Array.from(atob(part.textContent ?? ""), (c) => c.charCodeAt(0));
  part.remove(); // frees its text, which is as large as the store
  return bytes;
});
const file = new Blob(parts);
const name =
  document.querySelector<HTMLMetaElement>("meta[name=isosplat-name]")?.content ?? "volume";
const isBundle = beginsAsBundle(new Uint8Array(await file.slice(0, 8).arrayBuffer()));
const target: Target = isBundle
  ? { name, scene: async () => bundleScene(new BlobSource(file, name)) }
  : { name, source: () => new BlobSource(file, name) };

startTheme();
await startLanguage();
const page = new VolumePage(root, target);
void page.firstContent.then(() => page.loadOverlay());
